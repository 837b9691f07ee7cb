"""A baseline that learns what is missing and names nothing: the calibrated model with a smooth push of 18 free numbers."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.cloth.effects import Effect
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.physics import ClothPhysics
from sim1.cloth.precise.held_places import held_places
from sim1.cloth.precise.simulate import NotConverged
from sim1.cloth.precise.world import World
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import fit, temper_of
from sim1.mismatch.heldout import rmse_of
from sim1.mismatch.model_file import known_places
from sim1.mismatch.search import AXES, Term, Unknowns, baseline
from sim1.recording.bundle import Bundle

PUSH, BRAKE = 0.1, 0.2  # prior standard deviations, in units of the weight per area, and of that at 1 m/s
NAMES = tuple(f"{kind}/{b}/{axis}" for b in ("1", "s", "t") for kind in ("push", "brake") for axis in "xyz")


@dataclass(frozen=True, kw_only=True)
class SmoothPush(Effect):
    """`sim1/cloth/precise/smooth_push.py` as a term of a fit; it stands in no registry, so that no diagnosis tries it."""

    name: ClassVar[str] = "smooth_push"

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this push; `values` by name of coefficient."""
        return replace(world, smooth_push=tuple(values[name] for name in NAMES))


def smooth_term(weight_pa: float) -> Term:
    """The push with priors in units of a sheet's weight per area [Pa], centred at none."""
    coefficients = (
        Coefficient(
            name=name,
            unit="Pa" if name.startswith("push") else "Pa s/m",
            scale=weight_pa * (PUSH if name.startswith("push") else BRAKE),
        )
        for name in NAMES
    )
    return Term(effect=SmoothPush, coefficients=tuple(coefficients))


def heldout_m(bundle: Bundle, physics: ClothPhysics, held: str) -> float | None:
    """Error [m] on the recording `held` of the calibrated model `physics` with a smooth push, fitted to the other recordings.

    None: no simulation of it found its way.
    """
    plain = baseline(bundle)
    start = calibrated_z(bundle, plain, physics)
    weight_pa = physics.area_density_kg_m2.value * float(np.linalg.norm(bundle.environment.gravity_m_s2))
    model = plain.with_terms(smooth_term(weight_pa))
    z = np.concatenate([start, np.zeros(model.count - plain.count)])
    with Engine(bundle) as engine:
        names = tuple(name for name in engine.names if name != held)
        try:
            engine.refine(model.world(z), names)
            looked = engine.soften(model, z, names)
            temper = temper_of(engine, looked[0], names)
            found = fit(engine, model, z, names, temper=temper, given=looked)
            markers = engine.foretell(model.world(found.z), (held,))
        except NotConverged:
            return None
    return rmse_of(bundle, markers, (held,))


def calibrated_z(bundle: Bundle, plain: Unknowns, physics: ClothPhysics) -> np.ndarray:
    """Z (P,) of the model file of a calibrated baseline: what `physics_of` has written, back again."""
    places = _place_shifts(bundle, physics)
    found = []
    for c in plain.nominal:
        if c.name.startswith("place/"):
            _, grip, axis = c.name.split("/")
            value = places[int(grip)][AXES.index(axis)]
        elif c.name in physics.mesh:
            value = physics.mesh[c.name]
        else:
            value = (physics.friction.table if c.name == "friction" else getattr(physics, c.name)).value
        found.append(c.z(float(value)))
    low, high = plain.bounds()
    return np.clip(found, low, high)


def _place_shifts(bundle: Bundle, physics: ClothPhysics) -> dict[int, np.ndarray]:
    """Per grip whose places were fitted: shift (3) [m] and turn (3) [rad] from the estimated ones."""
    known, held, found = known_places(physics), held_places(bundle), {}
    for index, key in enumerate(held.keys):
        if key in known:
            before, after = held.places_m[key], known[key]
            turn = _turn(before - before.mean(0), after - after.mean(0))
            found[index] = np.concatenate([after.mean(0) - before.mean(0), turn])
    return found


def _turn(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """The smallest rotation vector (3,) [rad] that takes points (h, 3) to others: points on a line leave one open."""
    turn = Rotation.identity()
    for _ in range(4):
        now = turn.apply(before)
        columns = np.concatenate([np.cross(np.eye(3), point).T for point in now])  # of w x point, over w
        turn = Rotation.from_rotvec(np.linalg.lstsq(columns, (after - now).ravel(), rcond=1e-9)[0]) * turn
    return turn.as_rotvec()
