"""The robot and its grippers: late, yielding, slipping, shaking."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.grips import Poses
from benchmarks.concealed.world import State, World


@dataclass
class ActuatorLag(Effect):
    """Each coordinate of the pose follows its command as a critically damped servo, of second order.

    A drive whose position loop is tuned not to overshoot: T^2 p'' + 2 T p' + p = command with T half the `time_constant`, which is two lags of T
    one after the other. A steady motion is late by `time_constant`, as after one lag of first order with that time, and so is the response to any
    command on the mean (the first moment of the impulse response); a jump starts smoothly and is caught up with sooner.
    """

    name: ClassVar[str] = "actuator_lag"
    formula: ClassVar[str] = (
        "(time_constant / 2)^2 p'' + time_constant p' + p = command, the same for the rotation's vector against the first pose"
    )

    def poses(self, times_s: np.ndarray, poses: Poses) -> Poses:
        """Filter from the first pose on; each of both lags is exact for what is straight between samples (first-order hold)."""
        if len(times_s) < 2:
            return poses
        step = times_s[1] - times_s[0]
        time = self.parameters["time_constant"] / 2
        decay = np.exp(-step / time)
        after = 1 - time / step * (1 - decay)
        ahead, behind = after, 1 - decay - after
        first = poses.rotation[0]
        turned = Rotation.from_matrix((np.swapaxes(first, -1, -2) @ poses.rotation).reshape(-1, 3, 3)).as_rotvec()
        turned = turned.reshape(poses.position_m.shape)
        late = Rotation.from_rotvec(_follow(turned, ahead, behind, decay).reshape(-1, 3)).as_matrix()
        position = poses.position_m[0] + _follow(poses.position_m - poses.position_m[0], ahead, behind, decay)
        return Poses(position, first @ late.reshape(poses.rotation.shape))


def _follow(command: np.ndarray, ahead: float, behind: float, decay: float) -> np.ndarray:
    """y[n] = decay y[n-1] + ahead u[n] + behind u[n-1] along axis 0, from 0; twice."""
    for _ in range(2):
        command = lfilter([ahead, behind], [1.0, -decay], command, axis=0)
    return command


@dataclass
class GripperVibration(Effect):
    """Outside the table: a gripper shakes while the robot moves."""

    name: ClassVar[str] = "gripper_vibration"
    formula: ClassVar[str] = "position + amplitude sin(2 pi rate t) along one direction, faded in from 0.55 s to 0.8 s"

    def poses(self, times_s: np.ndarray, poses: Poses) -> Poses:
        """Shake all drives alike."""
        p = self.parameters
        course = p["amplitude"] * np.sin(2 * np.pi * p["rate"] * times_s) * np.clip((times_s - 0.55) / 0.25, 0, 1)
        way = np.array([self.extras[key] for key in ("x", "y", "z")])
        return Poses(poses.position_m + course[:, None, None] * way, poses.rotation)


@dataclass
class GripSlip(Effect):
    """The cloth creeps out of a gripper whose load in the sheet's plane is above a threshold, and stays where it got."""

    name: ClassVar[str] = "grip_slip"
    formula: ClassVar[str] = (
        "per gripper: speed rate * (|F| - threshold) along F, F its total load in the plane of its jaws"
    )

    def begin(self, world: World) -> None:
        """All in place."""
        self._slipped = np.zeros((len(world.holds.offsets_m), 3))
        self._drive = world.holds.drive

    def advance(self, state: State, step_s: float) -> None:
        """Creep, in the gripper's frame."""
        if state.relaxing:
            return
        load = np.einsum("dji,dj->di", state.drive_rotation, state.grip_load_n)
        load[:, 2] = 0.0
        size = np.linalg.norm(load, axis=1)
        over = np.maximum(size - self.parameters["threshold"], 0.0)
        self._slipped += (self.parameters["rate"] * step_s * over / np.maximum(size, 1e-12))[:, None] * load

    def grip_shift(self, state: State) -> np.ndarray | None:
        """(K, 3) creep in world axes."""
        return np.einsum("dij,dj->di", state.drive_rotation, self._slipped)[self._drive]


@dataclass
class GripCompliance(Effect):
    """The grip yields as a spring, per gripper and in all directions.

    A little mass moves with the spring, half of critically damped: without it, spring and cloth would be stiff against each
    other, and no explicit step could carry them.
    """

    name: ClassVar[str] = "grip_compliance"
    formula: ClassVar[str] = (
        "per gripper: jaw_mass * s'' + sqrt(stiffness * jaw_mass) * s' + stiffness * s = total load"
    )

    def begin(self, world: World) -> None:
        """Not yielded yet."""
        self._yielded = np.zeros((len(world.holds.offsets_m), 3))
        self._speed = np.zeros_like(self._yielded)
        self._drive = world.holds.drive

    def advance(self, state: State, step_s: float) -> None:
        """One step of the jaw; critically damped while the cloth is brought to rest."""
        stiffness, mass = self.parameters["stiffness"], self.extras["jaw_mass"]
        damping = (2.0 if state.relaxing else 1.0) * np.sqrt(stiffness * mass)
        push = state.grip_load_n - stiffness * self._yielded - damping * self._speed
        self._speed += push * (step_s / mass)
        self._yielded += self._speed * step_s

    def grip_shift(self, state: State) -> np.ndarray | None:
        """(K, 3)"""
        return self._yielded[self._drive]
