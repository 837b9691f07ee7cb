"""What a located force depends on, and what it does not: speed, direction, curvature, strain, the table, the grips, the place on the cloth.

First the laws that it follows, then what it is stronger with: see `state_fields.py`; how that is decided: `dependence.py`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.stats import rankdata

from sim1.mismatch.dependence import Answer, Dependence, Ways, dependences
from sim1.mismatch.missing_force import Forces
from sim1.mismatch.shares import Shares
from sim1.mismatch.state_fields import LAWS, ROOM, STRENGTHS, TABLE, Law, Place, Strength, fixed

type Ranks = dict[str, dict[str, np.ndarray]]
"""Of each state by recording, (T, M)."""


@dataclass(frozen=True, kw_only=True)
class State:
    """One state of the sheet and whether the force depends on it."""

    name: str
    share: float  # of the force's square above noise, beyond the other states
    depends: Answer


@dataclass(frozen=True, kw_only=True)
class Asked:
    """A law or a strength that the force was set against: of a state's several ones, the best."""

    of: Law | Strength
    found: Dependence
    follows: bool  # the state itself; else what the laws explain is stronger with it
    # Of a law's first field [N per its unit]; of a strength, of which the sign alone counts, above 0 where the force is more of what it is elsewhere, 0 where it is another.
    factor: float


def asked_of(forces: tuple[Forces, ...], place: Place) -> list[Asked]:
    """What the force of some recordings, one at least, was asked; `place` (M,) says which markers are of its region.

    Chance is told by signs of the force, and the region is chosen by its square: that makes nothing of nothing.
    """
    strengths = [one for one in STRENGTHS if one.state != TABLE or forces[0].table_z_m is not None]
    ranks = {one.state: _ranks(forces, [one.value(force, place) for force in forces]) for one in strengths}
    strengths = [one for one in strengths if any(np.ptp(rank) for rank in ranks[one.state].values())]
    laws = [law for law in LAWS if law.state != TABLE or forces[0].table_z_m is not None]
    followed = _followed(forces, laws, strengths, ranks)
    taken = [one.of for one in followed if one.found.taken]
    if not taken:
        return followed

    def explained(one: Forces) -> list[np.ndarray]:
        return [field for part in taken for field in _fields(part, one, ranks)]

    done = {part.state for part in taken}
    return followed + _stronger(forces, explained, [one for one in strengths if one.state not in done], ranks)


def table_of(asked: Sequence[Asked]) -> tuple[State, ...]:
    """A row for each state: yes if the force follows it or is stronger with it, no if neither."""
    by_state: dict[str, list[Dependence]] = {}
    for one in asked:
        by_state.setdefault(one.of.state, []).append(one.found)
    return tuple(
        State(name=name, share=max(one.share for one in found), depends=_answer([one.answer for one in found]))
        for name, found in by_state.items()
    )


def _answer(answers: list[Answer]) -> Answer:
    if "yes" in answers:
        return "yes"
    return "undecided" if "undecided" in answers else "no"


def _fields(part: Law | Strength, one: Forces, ranks: Ranks) -> list[np.ndarray]:
    """Of a law its own; of a strength a push along each axis of the room, by its rank."""
    return part.fields(one) if isinstance(part, Law) else fixed(one, ranks[part.state][one.name])


def _followed(forces: tuple[Forces, ...], laws: list[Law], strengths: list[Strength], ranks: Ranks) -> list[Asked]:
    parts = [*laws, *strengths]
    columns = _numbered([len(_fields(part, forces[0], ranks)) for part in parts])
    shares = Shares.of(forces, lambda one: np.stack([field for part in parts for field in _fields(part, one, ranks)]))
    ways: Ways = {}
    of: dict[str, list[Law | Strength]] = {}
    for part, own in zip(parts, columns, strict=True):
        if shares.scale[own].any():  # else these recordings have nothing of it
            ways.setdefault(part.state, []).append(own)
            of.setdefault(part.state, []).append(part)
    found = dependences(shares, ways, [])
    factors = _factors(shares, ways, [], found)
    asked = []
    for state, one in found.items():
        part, factor = of[state][one.way], 0.0
        if one.taken and isinstance(part, Law):
            factor = factors[state][0]
        elif one.taken and ROOM.state in factors:
            factor = factors[state] @ factors[ROOM.state]
        asked.append(Asked(of=part, found=one, follows=True, factor=float(factor)))
    return asked


def _stronger(
    forces: tuple[Forces, ...],
    explained: Callable[[Forces], list[np.ndarray]],
    strengths: list[Strength],
    ranks: Ranks,
) -> list[Asked]:
    """Whether what the laws explain is stronger with a state."""
    plain = Shares.of(forces, lambda one: np.stack(explained(one)))
    before = list(range(len(plain.scale)))
    sizes = plain.factors(before)

    def fields(one: Forces) -> np.ndarray:
        base = np.stack(explained(one))
        push = np.tensordot(sizes, base, 1)
        return np.concatenate([base, *(ranks[each.state][one.name][None, ..., None] * push for each in strengths)])

    shares = Shares.of(forces, fields)
    ways: Ways = {one.state: [[len(before) + k]] for k, one in enumerate(strengths)}
    found = dependences(shares, ways, before)
    factors = _factors(shares, ways, before, found)
    return [
        Asked(of=one, found=found[one.state], follows=False, factor=float(factors.get(one.state, [0.0])[0]))
        for one in strengths
    ]


def _factors(shares: Shares, ways: Ways, before: list[int], found: dict[str, Dependence]) -> dict[str, np.ndarray]:
    """Of the fields of each state that is taken, beside each other."""
    own = {state: ways[state][one.way] for state, one in found.items() if one.taken}
    columns = [*before, *(column for part in own.values() for column in part)]
    every = dict(zip(columns, shares.factors(columns), strict=True))
    return {state: np.array([every[column] for column in part]) for state, part in own.items()}


def _numbered(counts: list[int]) -> list[list[int]]:
    ends = np.cumsum([0, *counts])
    return [list(range(a, b)) for a, b in pairwise(ends)]


def _ranks(forces: tuple[Forces, ...], values: list[np.ndarray]) -> dict[str, np.ndarray]:
    """From -1 to 1 among the numbers of all recordings; equal ones share their mean rank."""
    flat = rankdata(np.concatenate([one.ravel() for one in values]))
    ranks = 2.0 * (flat - 0.5) / len(flat) - 1.0
    parts = np.split(ranks, np.cumsum([one.size for one in values])[:-1])
    return {force.name: part.reshape(one.shape) for force, part, one in zip(forces, parts, values, strict=True)}
