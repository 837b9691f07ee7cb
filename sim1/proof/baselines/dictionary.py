"""The dictionary of a sparse regression: what every effect, and every parameter of the fabric, would push with along a motion."""

from dataclasses import dataclass, replace

import numpy as np

from sim1.cloth.effects import Site
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.precise.world import World
from sim1.mismatch.screen import possible
from sim1.mismatch.search import Term

# What is no force on the cloth has no column.
RIG = ("actuator_lag", "clock_offset", "frame_offset", "grip_compliance", "grip_slip")
FABRIC = ("area_density_kg_m2", "stretch_n_m", "bending_n_m", "damping_s", "friction")
CHANGE = 0.1  # of a parameter of the fabric, for its column
FARTHEST = 0.2, 5.0  # of its calibrated value that such a parameter is taken to


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One column: a coefficient of an effect at a typical strength, or a parameter of the fabric a little off."""

    name: str  # of the coefficient, or of the parameter
    term: Term | None  # None: the fabric
    step_z: float  # of the coefficient
    world: World  # the baseline's with it

    @property
    def coefficient(self) -> Coefficient:
        """Of the effect."""
        return next(c for c in self.term.coefficients if c.name == self.name)


def entries_of(plain: World, site: Site) -> list[Entry]:
    """All columns: every strength of every effect on cloth at each of its variants, then the fabric."""
    found = []
    for effect in possible(site, ()):
        if effect.name in RIG:
            continue
        for variant in effect.variants(site):
            term = Term.of(effect, variant)
            for c in term.coefficients:
                if not c.shape:
                    step_z = 1.0 if c.value(1.0) < c.high else -1.0
                    values = {other.name: other.value(step_z * (other is c)) for other in term.coefficients}
                    world = effect.alter(plain, values)
                    found.append(Entry(name=c.name, term=term, step_z=step_z, world=world))
    for name in FABRIC:
        if name != "friction" or site.table:
            world = replace(plain, **{name: (1.0 + CHANGE) * getattr(plain, name)})
            found.append(Entry(name=name, term=None, step_z=1.0, world=world))
    return found


def world_with(
    plain: World, entries: list[Entry], shares: np.ndarray, sizes: np.ndarray
) -> tuple[World, tuple[str, ...]]:
    """The baseline's world with `shares` (C,) of each column in it, inside the coefficients' limits, and the effects' names.

    Of an effect with several variants, the one with the largest column counts, by `sizes` (C,) [N]. An effect that its limits leave nothing
    of is no name.
    """
    world, names = plain, []
    for entry, share in zip(entries, shares, strict=True):
        if entry.term is None and share:
            factor = float(np.clip(1.0 + CHANGE * share, *FARTHEST))
            world = replace(world, **{entry.name: factor * getattr(plain, entry.name)})
    terms: dict[str, dict[int, float]] = {}
    for entry, share, size in zip(entries, shares, sizes, strict=True):
        if entry.term is not None and _strength(entry, share) != entry.coefficient.value(0.0):
            ways = terms.setdefault(entry.term.effect.name, {})
            ways[id(entry.term)] = ways.get(id(entry.term), 0.0) + abs(share) * size
    for name, ways in terms.items():
        chosen = max(ways, key=ways.get)
        own = [(entry, share) for entry, share in zip(entries, shares, strict=True) if id(entry.term) == chosen]
        term = own[0][0].term
        values = {c.name: c.value(0.0) for c in term.coefficients}
        values |= {entry.name: _strength(entry, share) for entry, share in own}
        world = term.effect.alter(world, values)
        names.append(name)
    return world, tuple(sorted(names))


def _strength(entry: Entry, share: float) -> float:
    return entry.coefficient.value(float(entry.step_z * share))
