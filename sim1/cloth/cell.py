"""The simulated robot cell: two arms with grippers over a table, and a garment.

Arms follow their commands up to their speed limits and act on the cloth through their fingers and palms; the cloth does not
push the arms back (position-controlled arms, cloth of some grams).
"""

from pathlib import Path

import numpy as np

from sim1.cloth.bisect import bisected
from sim1.cloth.config import FRAME_S, CellConfig
from sim1.cloth.garment import GarmentMesh
from sim1.cloth.physics import ClothPhysics
from sim1.cloth.world import ClothWorld, SimulationBroke
from sim1.episode import ARMS
from sim1.robot.gripper import travel_from_openness
from sim1.robot.kinematics import Arm
from sim1.scene.description import Scene
from sim1.stage import BadInput

__all__ = ["FRAME_S", "Cell", "CellConfig", "SimulationBroke"]

FINGER_SPEED_M_S = 0.2  # limit of the finger joints in the URDF


class Cell:
    """`reset`, then `step` once per 1/30 s. Same inputs give the same bytes on CPU."""

    def __init__(
        self,
        garment: GarmentMesh,
        scene: Scene,
        physics: ClothPhysics,
        config: CellConfig,
        *,
        broken_to: Path | None = None,
    ) -> None:
        """The cell at home; `broken_to` (.npz) takes the last states when the simulation breaks."""
        if abs(scene.table_top_m) > 1e-9:
            raise BadInput(f"scene: table.top_m is {scene.table_top_m}, the world frame has it at 0")
        self.garment, self.scene, self.physics, self.config = garment, scene, physics, config
        self.arms = tuple(Arm.from_urdf(scene.urdf) for _ in ARMS)
        size = (float(scene.table_size_m[0]), float(scene.table_size_m[1]))
        self._finer = bisected(garment) if config.finer_mesh else None
        simulated = self._finer.mesh if self._finer else garment
        self._world = ClothWorld(simulated, physics, config, table_size_m=size, broken_to=broken_to)
        home = np.stack([scene.home_rad[name] for name in ARMS])
        self.reset(scene.place_garment(garment.vertices_m), home, np.ones(2))

    def reset(self, garment_m: np.ndarray, joints_rad: np.ndarray, openness: np.ndarray) -> None:
        """Start again: garment (v, 3) at rest there, arms (2, 6) and grippers (2,) standing there."""
        self.joints_rad = self._within_limits(joints_rad)
        self.openness = np.clip(np.asarray(openness, float), 0.0, 1.0)
        start_m = self._finer.refined(garment_m) if self._finer else garment_m
        self._world.reset(start_m, self.tool_poses(), 2.0 * travel_from_openness(self.openness))

    def step(self, joints_rad: np.ndarray, openness: np.ndarray) -> None:
        """Advance 1/30 s towards joints (2, 6) and openness (2,) as fast as the speed limits allow.

        Raises:
            ValueError: wrong shape, or not finite.
            SimulationBroke: the cloth's state stopped being sensible.
        """
        reach = np.stack([arm.velocity_limit_rad_s for arm in self.arms]) * FRAME_S
        target = self._within_limits(joints_rad)
        self.joints_rad = self.joints_rad + np.clip(target - self.joints_rad, -reach, reach)
        opening = np.asarray(openness, float)
        if opening.shape != (2,) or not np.isfinite(opening).all():
            raise ValueError(f"openness is {opening.tolist()}, expected two finite numbers in [0, 1]")
        step = FINGER_SPEED_M_S * FRAME_S / float(travel_from_openness(np.ones(())))
        self.openness = self.openness + np.clip(np.clip(opening, 0.0, 1.0) - self.openness, -step, step)
        self._world.step(self.tool_poses(), 2.0 * travel_from_openness(self.openness))

    @property
    def garment_m(self) -> np.ndarray:
        """Garment vertices (v, 3) float32 in the world frame, a copy."""
        return self._world.garment_m[: len(self.garment.rest_m)]

    @property
    def garment_m_s(self) -> np.ndarray:
        """Garment velocities (v, 3) float32, a copy."""
        return self._world.garment_m_s[: len(self.garment.rest_m)]

    @property
    def frame(self) -> int:
        """Frames since the last reset."""
        return self._world.frame

    def tool_poses(self, joints_rad: np.ndarray | None = None) -> np.ndarray:
        """Tool frames (2, 4, 4) in the world, of the given or the present joints (2, 6)."""
        joints = self.joints_rad if joints_rad is None else np.asarray(joints_rad, float)
        bases = [self.scene.base_to_world[name] for name in ARMS]
        return np.stack([base @ arm.forward(q) for base, arm, q in zip(bases, self.arms, joints)])

    def _within_limits(self, joints_rad: np.ndarray) -> np.ndarray:
        joints = np.asarray(joints_rad, float)
        if joints.shape != (2, 6) or not np.isfinite(joints).all():
            raise ValueError(f"joint command of shape {joints.shape} is not (2, 6) or not finite")
        return np.stack([np.clip(q, arm.lower_rad, arm.upper_rad) for q, arm in zip(joints, self.arms)])
