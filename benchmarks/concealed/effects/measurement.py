"""Cameras, clocks and the rig."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.concealed.effects.effect import Effect, Sampler
from benchmarks.concealed.motions.motion import DURATION_S
from benchmarks.concealed.world import Environment


@dataclass
class ClockOffset(Effect):
    """The cameras' clock is ahead, and runs a little fast or slow.

    Quartz clocks without a common reference differ by some tens of millionths (Allan 1987, Time and frequency characterization). `offset` is
    the mean over a recording; its ends are off by 0.2 ms at most, which hardly is a departure: a delay is one by nature.
    """

    name: ClassVar[str] = "clock_offset"
    formula: ClassVar[str] = "marker time stamp = true time + offset + drift (true time - middle of the recording)"
    measures_only: ClassVar[bool] = True

    def observe(self, stamps_s: np.ndarray, sample: Sampler) -> np.ndarray:
        """What was there about `offset` before the stamp."""
        middle = DURATION_S / 2
        return sample(middle + (stamps_s - middle - self.parameters["offset"]) / (1 + self.extras["drift"]))


@dataclass
class FrameOffset(Effect):
    """The cameras' frame is not the robot's."""

    name: ClassVar[str] = "frame_offset"
    formula: ClassVar[str] = "reported = R(rotation vector rx, ry, rz) x + t"
    measures_only: ClassVar[bool] = True

    def observe(self, stamps_s: np.ndarray, sample: Sampler) -> np.ndarray:
        """Turn and shift."""
        p = self.parameters
        turn = Rotation.from_rotvec([p["rx"], p["ry"], p["rz"]]).as_matrix()
        return sample(stamps_s) @ turn.T + np.array([p["tx"], p["ty"], p["tz"]])


@dataclass
class RollingShutter(Effect):
    """Outside the table: markers are seen one after another, higher ones first."""

    name: ClassVar[str] = "rolling_shutter"
    formula: ClassVar[str] = "marker seen `readout` seconds per metre below the highest one late"
    measures_only: ClassVar[bool] = True

    def observe(self, stamps_s: np.ndarray, sample: Sampler) -> np.ndarray:
        """Lower markers carry a stamp that is too early."""
        height = sample(stamps_s)[..., 2]
        late = self.parameters["readout"] * (height.max(axis=1, keepdims=True) - height)
        return sample(stamps_s + late)


@dataclass
class CameraScale(Effect):
    """Outside the table: the cameras' metre is not the robot's, about the middle of what they see."""

    name: ClassVar[str] = "camera_scale"
    formula: ClassVar[str] = "reported = c + scale (x - c), c a fixed point in the world"
    measures_only: ClassVar[bool] = True

    def observe(self, stamps_s: np.ndarray, sample: Sampler) -> np.ndarray:
        """Larger or smaller."""
        centre = np.array([self.extras[key] for key in ("x", "y", "z")])
        return centre + self.parameters["scale"] * (sample(stamps_s) - centre)


@dataclass
class GravityTilt(Effect):
    """The rig is not level."""

    name: ClassVar[str] = "gravity_tilt"
    formula: ClassVar[str] = "g = Ry(tilt_y) Rx(tilt_x) (0, 0, -9.81)"

    def environment(self, environment: Environment) -> Environment:
        """Gravity from another direction."""
        turn = Rotation.from_euler("y", self.parameters["tilt_y"]) * Rotation.from_euler("x", self.parameters["tilt_x"])
        return replace(environment, gravity_m_s2=turn.apply(environment.gravity_m_s2))
