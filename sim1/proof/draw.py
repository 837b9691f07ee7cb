"""Which cases a proof is made of: drawn by chance, mixed so that every beginning of the list is a fair sample; weak single effects come last."""

from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations
from pathlib import Path
from typing import Literal

import numpy as np
import pydantic

from sim1.data_file import explained, read_yaml
from sim1.mismatch.strict_json import Strict
from sim1.stage import BadInput

type Strength = Literal["weak", "medium", "strong"]

WHOLE = 60  # cases from which every effect of the table stands among them
MIX = {
    "null": Fraction(20, 60),
    "outside": Fraction(8, 60),
    "pair": Fraction(8, 60),
}  # the rest: one effect of the table
TWINS = frozenset(  # pairs that are no two things: measured alike, or one of them holds the other
    frozenset(pair)
    for pair in (("clock_offset", "actuator_lag"), ("frame_offset", "gravity_tilt"), ("air_drag", "wind"))
)
SEEDS = 2**32  # of cases
SHOWING: tuple[Strength, ...] = ("medium", "strong")  # strengths that should be found


class Case(Strict):
    """What the laboratory is asked for."""

    effects: tuple[str, ...]  # none: nothing is concealed
    strength: Strength = "medium"  # means nothing where nothing is concealed
    seed: pydantic.NonNegativeInt


def draw_cases(
    count: int,
    seed: int,
    *,
    table: Sequence[str],
    outside: Sequence[str],
    strength: Strength | None = None,
) -> tuple[Case, ...]:
    """Draw `count` cases; `table` and `outside` are the effects that the laboratory knows, with and without a name in the format.

    Without `strength`, one is drawn for each case (`_strengths`), which leaves effects and seeds as they are with one.

    Raises:
        BadInput: fewer than one case, or a laboratory without effects to draw from.
    """
    if count < 1:
        raise BadInput(f"--cases: {count}; a proof needs one case or more")
    if len(table) < 2 or not outside:
        raise BadInput(
            f"the laboratory knows {len(table)} effects with a name and {len(outside)} without; drawing needs two and one"
        )
    stream = np.random.default_rng(np.random.SeedSequence(seed))
    counts = composition(count)
    pairs = [pair for pair in combinations(table, 2) if frozenset(pair) not in TWINS]
    lots: dict[str, list[tuple[str, ...]]] = {
        "null": [()] * counts["null"],
        "outside": [(name,) for name in _dealt(outside, counts["outside"], stream)],
        "pair": [tuple(pair) for pair in _dealt(pairs, counts["pair"], stream)],
        "single": [(name,) for name in _dealt(table, counts["single"], stream)],
    }
    order = _mixed(counts, stream)
    seeds = stream.integers(SEEDS, size=count)
    drawn = (lots[kind].pop() for kind in order)
    strengths = [strength] * count if strength else _strengths(order, len(table), seed)
    return tuple(
        Case(effects=effects, strength=strong, seed=int(s))
        for effects, strong, s in zip(drawn, strengths, seeds, strict=True)
    )


def _strengths(order: Sequence[str], deck: int, seed: int) -> list[Strength]:
    """Of cases of these kinds, by a stream of their own: a fair coin's, but weak where every effect of the table, `deck` of them, was there already."""
    stream = np.random.default_rng(np.random.SeedSequence(seed).spawn(1)[0])
    strengths: list[Strength] = [SHOWING[k] for k in stream.integers(len(SHOWING), size=len(order))]
    singles = [place for place, kind in enumerate(order) if kind == "single"]
    strengths = ["medium" if kind == "null" else one for kind, one in zip(order, strengths, strict=True)]
    for place in singles[deck:]:
        strengths[place] = "weak"
    return strengths


def composition(count: int) -> dict[str, int]:
    """Cases of each kind: from 60 on 20, 8 and 8 and the rest single effects of the table, below in the same shares."""
    if count >= WHOLE:
        counts = {kind: int(share * WHOLE) for kind, share in MIX.items()}
    else:
        counts = {kind: round(share * count) for kind, share in MIX.items()}
    return {**counts, "single": count - sum(counts.values())}


def read_cases(path: Path) -> tuple[Case, ...]:
    """Read chosen cases, a YAML list of `{effects: [..], strength: medium, seed: 1}`; `none` among effects is nothing.

    Raises:
        BadInput: not readable, or not such a list.
    """
    content = read_yaml(path, "give a list of cases")
    try:
        cases = pydantic.TypeAdapter(tuple[Case, ...]).validate_python(content)
    except pydantic.ValidationError as error:
        raise BadInput(f"{path}: {explained(error)}") from error
    if not cases:
        raise BadInput(f"{path}: no case in it")
    return tuple(
        case.model_copy(update={"effects": tuple(name for name in case.effects if name != "none")}) for case in cases
    )


def _dealt(cards: Sequence, count: int, stream: np.random.Generator) -> list:
    """`count` cards from shuffled decks, one deck after the other: none comes again before all have come."""
    dealt: list = []
    while len(dealt) < count:
        dealt += [cards[k] for k in stream.permutation(len(cards))]
    return dealt[:count][::-1]  # taken from the end


def _mixed(counts: dict[str, int], stream: np.random.Generator) -> list[str]:
    """Kinds in an order in which each comes at even distances, from a start of its own by chance."""
    places = [
        ((k + start) / number, kind)
        for kind, number in counts.items()
        for start in [stream.random()]
        for k in range(number)
    ]
    return [kind for _, kind in sorted(places)]
