"""What a located force depends on, and what it does not: speed, direction, curvature, strain, the table, the grips, the place on the cloth.

First the laws that it follows, then what it is stronger with: see `state_fields.py`; how that is decided: `dependence.py`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.stats import rankdata

from sim1.mismatch.dependence import Answer, Dependence, Ways, dependences
from sim1.mismatch.missing_force import Forces
from sim1.mismatch.shares import Shares
from sim1.mismatch.state_fields import LAWS, ROOM, STRENGTHS, TABLE, Law, Place, Strength


@dataclass(frozen=True, kw_only=True)
class State:
    """One state of the sheet and whether the force depends on it."""

    name: str
    share: float  # of the force's square above noise, beyond the other states
    depends: Answer


@dataclass(frozen=True, kw_only=True)
class Asked:
    """A law or a strength that the force was set against: of a state's several laws, the best."""

    of: Law | Strength
    found: Dependence
    factor: float  # of its first field


def asked_of(forces: tuple[Forces, ...], place: Place) -> list[Asked]:
    """What the force of some recordings, one at least, was asked; `place` (M,) says which markers are of its region.

    Chance is told by signs of the force, and the region is chosen by its square: that makes nothing of nothing.
    """
    laws = [law for law in LAWS if law.state != TABLE or forces[0].table_z_m is not None]
    followed = _laws(forces, laws)
    taken = [one.of for one in followed if one.found.taken and isinstance(one.of, Law)]
    done = {law.state for law in taken}
    strengths = [
        one for one in STRENGTHS if one.state not in done and (one.state != TABLE or forces[0].table_z_m is not None)
    ]
    return followed + _strengths(forces, place, taken, strengths)


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


def _laws(forces: tuple[Forces, ...], laws: list[Law]) -> list[Asked]:
    columns = _numbered([len(law.fields(forces[0])) for law in laws])
    shares = Shares.of(forces, lambda one: np.stack([field for law in laws for field in law.fields(one)]))
    ways: Ways = {}
    places: dict[str, list[Law]] = {}
    for law, own in zip(laws, columns, strict=True):
        if shares.scale[own].any():  # else these recordings have nothing of it
            ways.setdefault(law.state, []).append(own)
            places.setdefault(law.state, []).append(law)
    found = dependences(shares, ways, [])
    return [_asked(places[state][one.way], one, ways, shares, [], found) for state, one in found.items()]


def _strengths(forces: tuple[Forces, ...], place: Place, laws: list[Law], strengths: list[Strength]) -> list[Asked]:
    """Whether what the laws explain is stronger with a state; without a law, whether a push in any direction of the room is."""
    ranks = {one.state: _ranks([one.value(force, place) for force in forces]) for one in strengths}
    varied = [one for one in strengths if any(np.ptp(rank) for rank in ranks[one.state])]
    order = {force.name: k for k, force in enumerate(forces)}

    def known(one: Forces) -> np.ndarray:
        return np.stack([field for law in laws or [ROOM] for field in law.fields(one)])

    plain = Shares.of(forces, known)
    before = list(range(len(plain.scale)))
    factors = plain.factors(before)

    def fields(one: Forces) -> np.ndarray:
        base = known(one)
        pushes = np.tensordot(factors, base, 1)[None] if laws else base
        return np.concatenate([base, *(ranks[each.state][order[one.name]][..., None] * pushes for each in varied)])

    shares = Shares.of(forces, fields)
    columns = _numbered([len(before), *(1 if laws else len(before) for _ in varied)])[1:]
    ways = {one.state: [own] for one, own in zip(varied, columns, strict=True)}
    found = dependences(shares, ways, before)
    return [_asked(one, found[one.state], ways, shares, before, found) for one in varied]


def _asked(
    of: Law | Strength, own: Dependence, ways: Ways, shares: Shares, before: list[int], found: dict[str, Dependence]
) -> Asked:
    """With the factor that its first field has beside all that is taken; 0 where it is not."""
    taken = [*before, *(column for state, one in found.items() if one.taken for column in ways[state][one.way])]
    column = ways[of.state][own.way][0]
    factor = float(shares.factors(taken)[taken.index(column)]) if own.taken else 0.0
    return Asked(of=of, found=own, factor=factor)


def _numbered(counts: list[int]) -> list[list[int]]:
    ends = np.cumsum([0, *counts])
    return [list(range(a, b)) for a, b in pairwise(ends)]


def _ranks(values: list[np.ndarray]) -> list[np.ndarray]:
    """From -1 to 1 among the numbers of all recordings; equal ones share their mean rank."""
    flat = rankdata(np.concatenate([one.ravel() for one in values]))
    ranks = 2.0 * (flat - 0.5) / len(flat) - 1.0
    parts = np.split(ranks, np.cumsum([one.size for one in values])[:-1])
    return [part.reshape(one.shape) for part, one in zip(parts, values, strict=True)]
