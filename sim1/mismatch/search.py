"""What a fit varies: the baseline's coefficients and those of effects, and the world that they make."""

from dataclasses import dataclass, replace

import numpy as np

from sim1.cloth.effects import Effect
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.precise.held_places import held_places
from sim1.cloth.precise.start import table_z
from sim1.cloth.precise.world import World
from sim1.recording.bundle import Bundle
from sim1.recording.unspread import POISSON_STD, UNITS

PLACE_STD_M, PLACE_STD_RAD = 0.006, 0.05  # of held vertices whose places were estimated from resting markers
LENGTH_STD = 7e-4  # of a sheet's length: what facets, and the formula of another mesh, leave open
CLAMP_LOG_STD, RIM_LOG_STD = 0.25, 0.5  # of the stiffness at the rim of a clamp, in bending and in the plane, likewise
AXES = ("tx", "ty", "tz", "rx", "ry", "rz")


@dataclass(frozen=True, kw_only=True)
class Term:
    """An effect in a model and the coefficients that are searched, shapes centred where the search starts."""

    effect: type[Effect]
    coefficients: tuple[Coefficient, ...]

    @classmethod
    def of(cls, effect: type[Effect], variant: dict[str, float] | None = None) -> "Term":
        """All coefficients of an effect; `variant` says where its shapes start."""
        variant = variant or {}
        return cls(
            effect=effect,
            coefficients=tuple(replace(c, centre=variant.get(c.name, c.centre)) for c in effect.coefficients),
        )


@dataclass(frozen=True, kw_only=True)
class Unknowns:
    """A model: base world, its calibrated coefficients, and added terms. z is zero at the prior means, without effects."""

    base: World
    nominal: tuple[Coefficient, ...]
    terms: tuple[Term, ...] = ()

    @property
    def all(self) -> tuple[Coefficient, ...]:
        """Every coefficient in the order of z."""
        return (*self.nominal, *(c for term in self.terms for c in term.coefficients))

    @property
    def count(self) -> int:
        """Length of z."""
        return len(self.all)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Limits (P,) of z."""
        low, high = [], []
        for c in self.all:
            edges = [c.z(edge) if np.isfinite(edge) else edge for edge in (c.low, c.high)]
            low.append(min(edges))
            high.append(max(edges))
        return np.array(low), np.array(high)

    def world(self, z: np.ndarray) -> World:
        """The world at `z`."""
        values = [c.value(float(v)) for c, v in zip(self.all, z, strict=True)]
        count = len(self.nominal)
        fields, places = {}, [list(row) for row in self.base.places]
        for c, value in zip(self.nominal, values[:count], strict=True):
            if c.name.startswith("place/"):
                _, grip, axis = c.name.split("/")
                places[int(grip)][AXES.index(axis)] = value
            else:
                fields[c.name] = value
        world = replace(self.base, places=tuple(tuple(row) for row in places), **fields)
        for term in self.terms:
            size = len(term.coefficients)
            named = {c.name: v for c, v in zip(term.coefficients, values[count : count + size], strict=True)}
            world, count = term.effect.alter(world, named), count + size
        return world

    def part(self, term: int) -> slice:
        """Where in z the coefficients of a term stand."""
        start = len(self.nominal) + sum(len(t.coefficients) for t in self.terms[:term])
        return slice(start, start + len(self.terms[term].coefficients))

    def values(self, term: int, z: np.ndarray) -> dict[str, float]:
        """Coefficients of a term at `z`."""
        chosen = self.terms[term].coefficients
        return {c.name: c.value(float(v)) for c, v in zip(chosen, z[self.part(term)], strict=True)}

    def strengths(self, term: int) -> list[int]:
        """Indices in z of the coefficients without which the term is nothing."""
        start = self.part(term).start
        return [start + k for k, c in enumerate(self.terms[term].coefficients) if not c.shape]

    def with_terms(self, *terms: Term) -> "Unknowns":
        """The same baseline with these terms alone."""
        return replace(self, terms=tuple(terms))


def baseline(bundle: Bundle) -> Unknowns:
    """The baseline model of a bundle, with the priors that the bundle states."""
    prior, table = bundle.prior, bundle.environment.table
    held = held_places(bundle)
    world = World(
        area_density_kg_m2=prior.area_density_kg_m2.value,
        stretch_n_m=prior.stretch_n_m.value,
        poisson=min(prior.poisson.value, 0.49),
        bending_n_m=prior.bending_n_m.value,
        damping_s=prior.damping_s.value,
        friction=table.friction.value if table else 0.0,
        table_z_m=table_z(bundle) if table else None,
        gravity_m_s2=tuple(bundle.environment.gravity_m_s2),
        air_density_kg_m3=bundle.environment.air_density_kg_m3,
        places=tuple((0.0,) * 6 for _ in held.keys),
        frame_centre_m=_middle_m(bundle),
    )
    found = []
    for name, unit in UNITS.items():
        stated = getattr(prior, name)
        if stated.log_spread:  # else taken as exact, which a verdict says (`unspread.py`)
            found.append(Coefficient(name=name, unit=unit, scale=stated.log_spread, kind="log", centre=stated.value))
    std = prior.poisson.spread or POISSON_STD
    found.append(Coefficient(name="poisson", unit="1", scale=std, centre=world.poisson, low=0.0, high=0.49))
    if table:
        stated = table.friction
        if stated.spread:
            found.append(Coefficient(name="friction", unit="1", scale=stated.spread, centre=stated.value, low=0.0))
    for grip, key in enumerate(held.keys):
        if key not in held.measured:
            for axis in AXES:
                unit, std = ("m", PLACE_STD_M) if axis[0] == "t" else ("rad", PLACE_STD_RAD)
                if axis[0] == "t" or len(key[1]) > 1:
                    found.append(Coefficient(name=f"place/{grip}/{axis}", unit=unit, scale=std))
    for name in ("length_u", "length_v"):
        found.append(Coefficient(name=name, unit="1", scale=LENGTH_STD, kind="log", centre=1.0, farthest_z=30.0))
    found.append(Coefficient(name="clamp", unit="1", scale=CLAMP_LOG_STD, kind="log", centre=world.clamp))
    found.append(Coefficient(name="rim", unit="1", scale=RIM_LOG_STD, kind="log", centre=world.rim))
    return Unknowns(base=world, nominal=tuple(found))


def _middle_m(bundle: Bundle) -> tuple[float, ...]:
    """Where markers are in the mean: turned about a far origin, they would mostly be shifted."""
    seen = np.concatenate([recording.markers_m[recording.seen] for recording in bundle.recordings])
    return tuple(seen.mean(0).tolist())
