"""What a force depends on and what it does not, in words: the end of a sentence that says how large it is."""

from collections.abc import Sequence

from sim1.mismatch.state import Asked, table_of
from sim1.mismatch.state_fields import TABLE, Law, Strength


def words_of(asked: Sequence[Asked]) -> str:
    """From all that a force was asked."""
    taken = [one for one in asked if one.found.taken]
    odd = [isinstance(one.of, Law) and one.of.reverses for one in taken if one.follows]
    phrases = [f"{_does(one)} ({100 * one.found.share:.0f} % of it)" for one in taken]
    parts = [f"it {_listed(phrases, 'and')}" if taken else "no dependence on a state is shown"]
    if odd and all(one.found.told or one.of.state != TABLE for one in taken if one.follows):  # one way of it is odd
        parts.append(f"{'all' if all(odd) else 'a part' if any(odd) else 'none'} of that reverses with the motion")
    twins: dict[str, list[str]] = {}
    for one in asked:
        if one.found.twin and not one.found.taken:
            twins.setdefault(one.found.twin, []).append(one.of.state)
    parts += [f"{_listed(states, 'or')} in place of {one} would explain as much" for one, states in twins.items()]
    rows = table_of(asked)
    ruled_out = [row.name for row in rows if row.depends == "no" and row.name != TABLE]
    if ruled_out:
        parts.append(f"it does not depend on {_listed(ruled_out, 'or')}")
    if any(row.name == TABLE and row.depends == "no" for row in rows):
        parts.append("it is the same on the table and off it")
    told = {*twins, *(state for states in twins.values() for state in states)}
    left_open = [row.name for row in rows if row.depends == "undecided" and row.name not in told]
    if left_open:
        parts.append(f"it is open whether it depends on {_listed(left_open, 'or')}")
    return "; ".join(parts)


def _does(one: Asked) -> str:
    if isinstance(one.of, Strength):
        if not one.factor:
            return f"pushes another way {one.of.words}"
        return f"is {'stronger' if one.factor > 0.0 else 'weaker'} {one.of.words}"
    words = one.of.words if one.found.told else one.of.vaguely
    against = one.factor < 0.0
    return words.format(brakes="brakes" if against else "drives", resists="resists" if against else "follows")


def _listed(parts: list[str], last: str) -> str:
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} {last} {parts[-1]}"
