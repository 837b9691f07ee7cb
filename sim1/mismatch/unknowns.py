"""What a calibration may change: parameters in units of their prior's spread."""

from dataclasses import dataclass, replace

import numpy as np

from sim1.mismatch.sheet import Material
from sim1.recording.document import Priors

FITTED = ("area_density_kg_m2", "stretch_n_m", "poisson", "bending_n_m", "damping_s")
LARGEST_POISSON, SMALLEST_POISSON = 0.49, 0.01
AIR_DRAG_PRIOR = (
    1.5,
    0.5,
)  # coefficient of a plate in still air and its log spread: steady 1.1 to 2, small oscillations above


@dataclass(frozen=True, kw_only=True)
class Unknown:
    """One parameter; z is its distance from the prior in standard deviations."""

    name: str
    prior: float
    spread: float  # standard deviation, of the logarithm where `log`
    log: bool

    def value(self, z: float) -> float:
        if self.log:
            return float(self.prior * np.exp(self.spread * z))
        return float(np.clip(self.prior + self.spread * z, SMALLEST_POISSON, LARGEST_POISSON))


def unknowns(priors: Priors, *, air_drag: bool) -> tuple[Unknown, ...]:
    """Parameters with a stated spread; one without is taken as known."""
    found = []
    for name in FITTED:
        prior = getattr(priors, name)
        log = name != "poisson"
        if prior.log_std and log:
            found.append(Unknown(name=name, prior=prior.value, spread=prior.log_std, log=True))
        elif prior.std:
            found.append(
                Unknown(name=name, prior=prior.value, spread=prior.std / prior.value if log else prior.std, log=log)
            )
    if air_drag:
        found.append(Unknown(name="c_normal", prior=AIR_DRAG_PRIOR[0], spread=AIR_DRAG_PRIOR[1], log=True))
    return tuple(found)


def prior_material(priors: Priors, air_density_kg_m3: float) -> Material:
    """The baseline at its prior means, without air drag."""
    return Material(**{name: getattr(priors, name).value for name in FITTED}, air_density_kg_m3=air_density_kg_m3)


def with_unknowns(material: Material, names: tuple[Unknown, ...], z: np.ndarray) -> Material:
    """`material` with the unknowns at `z`."""
    return replace(material, **{unknown.name: unknown.value(offset) for unknown, offset in zip(names, z, strict=True)})
