"""A frame (1/30 s) of a towel lying on the table: layers that collide against layers that do not."""

from typing import Any

import numpy as np

from benchmarks.timing import against
from sim1.cloth.config import CellConfig
from sim1.cloth.garment import grid_towel
from sim1.cloth.physics import nominal_from_priors
from sim1.cloth.world import ClothWorld

FRAMES = 10
FABRIC = {
    "area_density_kg_m2": {"value": 0.3},
    "thickness_m": {"value": 0.002},
    "stretch_n_m": {"value": 400.0},
    "poisson": {"value": 0.3},
    "bending_n_m": {"value": 5e-5},
    "damping_s": {"value": 1e-3},
}


def compare() -> dict[str, Any]:
    """Ten frames of a 0.4 x 0.3 m sheet, 20 mm edges."""
    towel = grid_towel(0.4, 0.3, 0.02)
    start = towel.rest_m + np.array([0, 0, 0.004])
    worlds = [ClothWorld(towel, nominal_from_priors(FABRIC), CellConfig(self_contact=on)) for on in (True, False)]

    def frames(world: ClothWorld) -> None:
        world.reset(start, world.tools, world.gaps_m)
        for _ in range(FRAMES):
            world.step(world.tools, world.gaps_m)

    return against(
        f"{FRAMES} frames of {len(towel.rest_m)} vertices with self-contact",
        lambda: frames(worlds[0]),
        "the same without",
        lambda: frames(worlds[1]),
    )
