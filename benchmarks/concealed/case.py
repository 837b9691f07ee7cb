"""One case: which effects, how strong, which motions. Everything follows from the effects, the strength and the seed."""

import zlib
from dataclasses import dataclass

import numpy as np

from benchmarks.concealed.effects.library import LIBRARY
from benchmarks.concealed.motions import FREE_MOTIONS, MOTIONS, TABLE_MOTIONS, Motion
from benchmarks.concealed.setting import Setting, draw_setting

STRENGTHS = {"weak": 0.3, "medium": 3.5, "strong": 10.0}
"""Change of the markers over the noise, both root mean square, in the motions that show the effect best.

Weak is below what a diagnosis can detect: what it says from there on that an effect shows was a fifth of medium, in the median of a campaign."""

FILMED = 5
HELD_OUT = 2
DRAWS = 200


@dataclass(frozen=True)
class Plan:
    """One motion to film."""

    name: str
    motion: Motion
    shown: bool
    """Whether it excites the effect."""
    held_out: bool


@dataclass(frozen=True)
class Case:
    """A bundle to make."""

    effects: tuple[str, ...]
    strength: str
    seed: int
    motions: tuple[str, ...] = ()
    """To film, in place of those that are drawn."""

    def __post_init__(self) -> None:
        """Refuse what there is not."""
        for name in self.effects:
            if name not in LIBRARY:
                raise ValueError(f"no effect {name!r}: choose from {', '.join(LIBRARY)}")
        if self.strength not in STRENGTHS:
            raise ValueError(f"no strength {self.strength!r}: choose from {', '.join(STRENGTHS)}")
        for name in self.motions:
            if name not in MOTIONS:
                raise ValueError(f"no motion {name!r}: choose from {', '.join(MOTIONS)}")

    @property
    def folder(self) -> str:
        """Name of its folder: medium, the usual strength, goes without saying."""
        strength = "" if self.strength == "medium" or not self.effects else f"_{self.strength}"
        return f"{'+'.join(self.effects) or 'none'}{strength}_{self.seed}"

    def stream(self, purpose: str) -> np.random.Generator:
        """Random numbers for one purpose; a change in one leaves the others as they are."""
        key = f"{'+'.join(self.effects)}|{purpose}"
        return np.random.default_rng([self.seed, zlib.crc32(key.encode())])

    def setting(self) -> Setting:
        """The truth, effects aside."""
        return draw_setting(self.stream("setting"))


def plans(case: Case, setting: Setting) -> list[Plan]:
    """FILMED motions, at least three of which show the effect, and HELD_OUT others, the first of which does; or those that were chosen.

    Others are of other names, not filmed ones with other amplitudes, and of grips and contacts that filmed ones have.
    """
    rng = case.stream("motions")
    shown_by = sorted({name for effect in case.effects for name in LIBRARY[effect].shown_by}, key=list(MOTIONS).index)
    chosen, held_out = (list(case.motions), []) if case.motions else _drawn(case, shown_by, setting, rng)
    out = []
    for number, name in enumerate([*chosen, *held_out]):
        motion = MOTIONS[name](setting.cloth, setting.columns, setting.rows, rng)
        placed = motion.placed(setting.yaw_rad + rng.normal(0, 0.05), setting.shift_m)
        out.append(Plan(f"{name}_{'abcdefghijklmnop'[number]}", placed, name in shown_by, number >= len(chosen)))
    return out


def _drawn(case: Case, shown_by: list[str], setting: Setting, rng: np.random.Generator) -> tuple[list[str], list[str]]:
    """Motions to film, in their order, and to hold out; drawn again until what is filmed leaves two that it says enough of."""
    for _ in range(DRAWS):
        pool = _pool(case, shown_by, rng)
        shown = [str(name) for name in rng.permutation(shown_by or pool)]
        chosen = _spread(case, shown, rng)
        rest = [str(name) for name in rng.permutation([name for name in pool if name not in chosen])]
        chosen += rest[: FILMED - len(chosen)]
        known = [name for name in rest if name not in chosen and _foretellable(name, chosen, setting)]
        first = next((name for name in shown if name in known), None)
        others = [name for name in known if name != first]
        if first and others:
            return [str(name) for name in rng.permutation(chosen)], [first, others[0]]
    raise ValueError(
        f"{case.folder}: {DRAWS} draws of {FILMED} motions left no {HELD_OUT} others with their grips and their table, one of which "
        f"shows an effect: add to the motions that do (benchmarks/concealed/effects/library.py): {', '.join(shown_by)}"
    )


def _pool(case: Case, shown_by: list[str], rng: np.random.Generator) -> list[str]:
    """Motions that may be filmed beside those that show the effects."""
    if any(name in TABLE_MOTIONS for name in shown_by):
        return [*TABLE_MOTIONS, *rng.choice(FREE_MOTIONS, 3, replace=False)]
    if case.effects and all(LIBRARY[effect].loose for effect in case.effects) and rng.random() < 0.4:
        return [*FREE_MOTIONS, *rng.choice(TABLE_MOTIONS, 2, replace=False)]
    if not case.effects and rng.random() < 0.5:
        return [*rng.choice(FREE_MOTIONS, 5, replace=False), *TABLE_MOTIONS]
    return list(FREE_MOTIONS)


def _foretellable(name: str, filmed: list[str], setting: Setting) -> bool:
    """Whether filmed motions have its table, if it has one, and all of its grips: nothing else tells how those hold the cloth."""
    seen = [_bare(other, setting) for other in filmed]
    motion = _bare(name, setting)
    grips = {block for other in seen for block in other.blocks}
    return set(motion.blocks) <= grips and (not motion.table or any(other.table for other in seen))


def _bare(name: str, setting: Setting) -> Motion:
    """A motion of that name: amplitudes do not matter to who asks for its grips."""
    return MOTIONS[name](setting.cloth, setting.columns, setting.rows, np.random.default_rng(0))


def _spread(case: Case, shown: list[str], rng: np.random.Generator) -> list[str]:
    """The motions that show the effects: three, and for several effects two of each at least."""
    if len(case.effects) < 2:
        return shown[: min(3, len(shown))]
    chosen: list[str] = []
    for effect in case.effects:
        own = [name for name in shown if name in LIBRARY[effect].shown_by]
        have = [name for name in own if name in chosen]
        chosen += [name for name in own if name not in chosen][: max(0, 2 - len(have))]
    return chosen[:FILMED]
