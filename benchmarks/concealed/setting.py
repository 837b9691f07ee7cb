"""What is drawn for a bundle before anything moves: cloth, mesh, room, cameras, and what the lab believes of them."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.concealed.cloth import Cloth

REFINE = 2
"""The laboratory's mesh against the bundle's, per side."""

DENSITY_STD_SHARE = 0.04
POISSON_STD = 0.08
LOG_STD = {"stretch_n_m": 0.5, "bending_n_m": 0.6, "damping_s": 0.7}
FRICTION_STD = 0.12
"""How far off the priors may be: what a data sheet knows."""


@dataclass(frozen=True)
class Setting:
    """The truth of one bundle, effects aside. SI units."""

    cloth: Cloth
    columns: int
    rows: int
    """Vertices of the bundle's mesh."""
    friction: float
    air_density_kg_m3: float
    yaw_rad: float
    shift_m: np.ndarray
    """(3,) where the rig stands; horizontal."""
    noise_m: float
    """Root mean square per coordinate, all parts together."""
    noise_stated: bool
    places_given: bool
    marker_hz: float
    drive_hz: float

    def in_room(self, local_m: np.ndarray) -> np.ndarray:
        """A point (3,) or direction of the rig's axes, turned and shifted to the world."""
        return Rotation.from_euler("z", self.yaw_rad).apply(local_m) + self.shift_m


def draw_setting(rng: np.random.Generator) -> Setting:
    """A light to medium canvas of 0.25 to 0.4 m, stiff enough in bending to move in a way that can be foretold."""

    def log_uniform(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    columns, rows = (int(n) for n in rng.integers(11, 14, 2))
    size_u = rng.uniform(0.26, 0.36)
    cloth = Cloth(
        size_u_m=round(float(size_u), 3),
        size_v_m=round(float(np.clip(size_u * rng.uniform(0.85, 1.15), 0.25, 0.4)), 3),
        area_density_kg_m2=log_uniform(0.15, 0.26),
        thickness_m=round(float(rng.uniform(0.0006, 0.0012)), 5),
        stretch_n_m=log_uniform(220, 600),
        poisson=float(rng.uniform(0.2, 0.4)),
        bending_n_m=log_uniform(8e-5, 2.5e-4),
        damping_s=log_uniform(7e-4, 2e-3),
    )
    return Setting(
        cloth=cloth,
        columns=columns,
        rows=rows,
        friction=float(rng.uniform(0.3, 0.6)),
        air_density_kg_m3=1.2,
        yaw_rad=float(rng.uniform(-0.5, 0.5)),
        shift_m=np.array([*rng.uniform(-0.2, 0.2, 2), 0.0]),
        noise_m=log_uniform(0.0003, 0.001),
        noise_stated=bool(rng.random() < 0.4),
        places_given=bool(rng.random() < 0.8),
        marker_hz=float(rng.choice([60.0, 72.0, 80.0, 100.0])),
        drive_hz=float(rng.uniform(95, 105)),
    )


def draw_prior(setting: Setting, rng: np.random.Generator) -> dict[str, dict[str, float]]:
    """What a data sheet says: off from the truth as far as its stated spread makes likely (1.8 spreads at most)."""
    cloth = setting.cloth

    def off() -> float:
        return float(np.clip(rng.normal(), -1.8, 1.8))

    def within(name: str) -> dict[str, float]:
        log_std = LOG_STD[name]
        return {"value": _rounded(getattr(cloth, name) * np.exp(log_std * off())), "log_std": log_std}

    density_std = DENSITY_STD_SHARE * cloth.area_density_kg_m2
    return {
        "area_density_kg_m2": {
            "value": _rounded(cloth.area_density_kg_m2 + density_std * off()),
            "std": _rounded(density_std),
        },
        "thickness_m": {"value": cloth.thickness_m},
        "stretch_n_m": within("stretch_n_m"),
        "poisson": {
            "value": round(float(np.clip(cloth.poisson + POISSON_STD * off(), 0.05, 0.45)), 3),
            "std": POISSON_STD,
        },
        "bending_n_m": within("bending_n_m"),
        "damping_s": within("damping_s"),
    }


def draw_friction_prior(setting: Setting, rng: np.random.Generator) -> dict[str, float]:
    """What the lab believes of the table."""
    return {
        "value": round(float(np.clip(setting.friction + FRICTION_STD * rng.normal(), 0.1, 0.9)), 3),
        "std": FRICTION_STD,
    }


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")
