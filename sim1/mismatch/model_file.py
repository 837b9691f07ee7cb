"""A fitted model as `model.yaml`, and a world back from it."""

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.cloth.effects import Effect, effects_of
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.physics import MESH, PRIOR_FRICTION, ClothPhysics, Friction, Property
from sim1.cloth.precise.held_places import REGRIPPED_M, Key, held_places, resting_places, short_of
from sim1.cloth.precise.start import table_z
from sim1.cloth.precise.world import World
from sim1.mismatch.engine import mesh_for
from sim1.mismatch.fit import Fit
from sim1.mismatch.search import PLACE_STD_M
from sim1.mismatch.uncertainty import covariance, deviations
from sim1.recording.bundle import Bundle

SAMPLES = 400  # of the posterior, for intervals of what is computed from coefficients
# From where a fit found the cloth in a grip, which is within three deviations of where markers at rest say that it is.
TAKEN_ANEW_M = REGRIPPED_M + 3 * PLACE_STD_M
FABRIC = ("area_density_kg_m2", "thickness_m", "stretch_n_m", "poisson", "bending_n_m", "damping_s")


def interval(c: Coefficient, z: float, deviation: float) -> tuple[float, float]:
    """95 % interval of a coefficient, in its unit."""
    low, high = sorted((c.value(z - 1.96 * deviation), c.value(z + 1.96 * deviation)))
    return low, high


def physics_of(bundle: Bundle, found: Fit) -> ClothPhysics:
    """The model file of a fit; what was not fitted keeps its prior value and has no interval."""
    nominal = {
        c.name: Property(value=c.value(z), ci95=interval(c, z, deviation))
        for c, z, deviation in zip(found.unknowns.nominal, found.z, deviations(found), strict=False)
    }
    values = {name: nominal.get(name, Property(value=getattr(bundle.prior, name).value)) for name in FABRIC}
    friction = Friction()
    if bundle.environment.table is not None:
        table = nominal.get("friction", Property(value=bundle.environment.table.friction.value))
        friction = Friction(table=table)
    world = found.unknowns.world(found.z)
    return ClothPhysics(
        **values,
        friction=friction,
        effects=tuple(effect_entry(found, index) for index in range(len(found.unknowns.terms))),
        grips=_grips(bundle, world),
        mesh={c.name: float(getattr(world, c.name)) for c in found.unknowns.nominal if c.name in MESH},
        mesh_refined=mesh_for(bundle),
    )


def effect_entry(found: Fit, term: int) -> dict[str, Any]:
    """`{name, parameters: {p: {value, ci95, unit}}}` of a term, intervals from normal samples of z."""
    effect: type[Effect] = found.unknowns.terms[term].effect
    stream = np.random.default_rng(0)
    low, high = found.unknowns.bounds()
    draws = stream.multivariate_normal(found.z, covariance(found), size=SAMPLES, method="eigh")
    draws = np.clip(draws, low, high)
    at = effect.published(found.unknowns.world(found.z), found.unknowns.values(term, found.z))
    sampled = [effect.published(found.unknowns.world(z), found.unknowns.values(term, z)) for z in draws]
    parameters = {}
    for name, value in at.items():
        edges = np.quantile([one[name] for one in sampled], [0.025, 0.975])
        parameters[name] = {
            "value": float(value),
            "ci95": [float(min(edges[0], value)), float(max(edges[1], value))],
            "unit": effect.units()[name],
        }
    return {"name": effect.name, "parameters": parameters}


def _grips(bundle: Bundle, world: World) -> tuple[dict[str, Any], ...]:
    """Places of held vertices that nobody measured and the fit found."""
    held, found = held_places(bundle), []
    for index, key in enumerate(held.keys):
        if key not in held.measured:
            places, shift = held.places_m[key], np.array(world.places[index])
            middle = places.mean(0)
            moved = Rotation.from_rotvec(shift[3:]).apply(places - middle) + middle + shift[:3]
            entry = {"drive": key[0], "vertices": list(key[1]), "places_m": [[float(x) for x in row] for row in moved]}
            found.append(entry | ({"recording": key[2]} if key[2] else {}))
    return tuple(found)


def world_of(physics: ClothPhysics, bundle: Bundle) -> World:
    """The world of a model file in the surroundings of a bundle."""
    table = bundle.environment.table
    world = World(
        area_density_kg_m2=physics.area_density_kg_m2.value,
        stretch_n_m=physics.stretch_n_m.value,
        poisson=min(physics.poisson.value, 0.49),
        bending_n_m=physics.bending_n_m.value,
        damping_s=physics.damping_s.value,
        friction=physics.friction.table.value if table else PRIOR_FRICTION["table"],
        table_z_m=table_z(bundle) if table else None,
        gravity_m_s2=tuple(bundle.environment.gravity_m_s2),
        air_density_kg_m3=bundle.environment.air_density_kg_m3,
        places=tuple((0.0,) * 6 for _ in held_places(bundle).keys),
        **physics.mesh,
    )
    for effect in effects_of(physics.effects):
        world = effect.act(world)
    return world


def known_places(physics: ClothPhysics) -> dict[Key, np.ndarray]:
    """Places (h, 3) m that a model file holds."""
    return {
        (grip["drive"], tuple(grip["vertices"]), grip.get("recording", ""), 0): np.array(grip["places_m"])
        for grip in physics.grips
    }


def with_grips(bundle: Bundle, physics: ClothPhysics) -> Bundle:
    """The bundle with the places that the model file knows, where the bundle knows none and its resting markers do not say that the
    cloth was taken up anew.

    Raises:
        BadInput: too few markers are seen at rest in a grip that nobody measured.
    """
    known, resting, recordings = known_places(physics), resting_places(bundle), []
    for recording in bundle.recordings:
        holds = []
        for hold in recording.holds:
            short = short_of(hold)
            found = known.get((*short, recording.name, 0), known.get((*short, "", 0)))
            seen = resting.get(short, {}).get(recording.name)
            if found is not None and seen is not None and np.linalg.norm((seen - found).mean(0)) > TAKEN_ANEW_M:
                found = None
            holds.append(replace(hold, places_m=found if hold.places_m is None else hold.places_m))
        recordings.append(replace(recording, holds=tuple(holds)))
    return replace(bundle, recordings=tuple(recordings))
