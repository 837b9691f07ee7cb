"""Which points over the table the arms reach with the tool pointing down, or leaning outward by how much."""

from dataclasses import dataclass

import numpy as np

from sim1.robot.planar import PlanarArm
from sim1.scene.description import Scene

TILTS_DEG = tuple(range(0, 90, 5))


@dataclass(frozen=True, kw_only=True)
class Reach:
    """Least leaning, in degrees, with which each arm reaches each of n points; inf where it does not."""

    tilt_deg: dict[str, np.ndarray]  # arm -> (n,)

    def either(self) -> np.ndarray:
        """The better of the arms, (n,)."""
        return np.minimum.reduce(list(self.tilt_deg.values()))

    def share(self, largest_tilt_deg: float) -> float:
        """Share of the points that at least one arm reaches leaning by at most that much."""
        return float((self.either() <= largest_tilt_deg).mean())


def reach_of(points_m: np.ndarray, scene: Scene, arm: PlanarArm) -> Reach:
    """Reach of the scene's arms to points (n, 3) in the world, in steps of 5 degrees; ignores obstacles."""
    tilts = {}
    for name, base in scene.base_to_world.items():
        local = (points_m - base[:3, 3]) @ base[:3, :3]
        least = np.full(len(points_m), np.inf)
        for tilt in reversed(TILTS_DEG):
            least[np.isfinite(arm.postures(local, np.radians(tilt))[:, 0])] = tilt
        tilts[name] = least
    return Reach(tilt_deg=tilts)


def over_table(size_m: np.ndarray, height_m: float, step_m: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Grid over the table at a height: x (i,), y (j,), points (i * j, 3)."""
    x, y = (np.linspace(-side / 2, side / 2, round(side / step_m) + 1) for side in size_m[:2])
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return x, y, np.column_stack([grid, np.full(len(grid), height_m)])


def work_region(scene: Scene, step_m: float = 0.05) -> np.ndarray:
    """Points (n, 3) of the region that folding needs, measured from the base line.

    0.15 to 0.6 m ahead, 0.35 m to either side, up to 0.25 m above the table.
    """
    back = np.mean([pose[0, 3] for pose in scene.base_to_world.values()])
    x = back + np.arange(0.15, 0.6 + 1e-9, step_m)
    y = np.arange(-0.35, 0.35 + 1e-9, step_m)
    z = scene.table_top_m + np.arange(0.0, 0.25 + 1e-9, step_m)
    return np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
