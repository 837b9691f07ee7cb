"""Demonstrations that a person gave: commands of both arms, as a LeRobot dataset of any rate holds them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.dataset.reshape import lerobot_root
from sim1.dataset.tables import column, read_tables
from sim1.episode import ARMS, JOINT_COUNT, RATE_HZ, STATE_NAMES
from sim1.robot.kinematics import Arm
from sim1.stage import BadInput

ACTION, STATE = "action", "observation.state"
ROUNDING_RAD = 1e-6  # angles in float32, converted from degrees or not, are this near to what was meant
LAG_RAD = 0.02  # a joint farther behind its command does not follow it


@dataclass(frozen=True, kw_only=True)
class Commands:
    """What the arms were asked for in one demonstration, at `RATE_HZ`; arms in the order of `ARMS`."""

    origin: str  # which episode of which dataset
    start_joints_rad: np.ndarray  # (2, 6) where the arms stood
    start_openness: np.ndarray  # (2,)
    joints_rad: np.ndarray  # (T, 2, 6)
    openness: np.ndarray  # (T, 2) in [0, 1], 1 is open


def read_commands(folder: Path) -> list[Commands]:
    """Commands of every episode of the LeRobot dataset in `folder`, or in `folder/lerobot`.

    An action leads from its frame to the next one; in between the arms are led evenly (`Episode.action_until_next`, the other way round).
    Pictures, if there are any, are not looked at.

    Raises:
        BadInput: no such dataset, other names of actions or states than `STATE_NAMES`, a number that is not finite, an openness
            outside [0, 1], or an episode of one frame.
    """
    root = lerobot_root(folder)
    try:
        tables = read_tables(root)
        features, rate_hz = tables.info["features"], float(tables.info["fps"])
        names = {key: list(features[key]["names"]) for key in (ACTION, STATE)}
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise BadInput(f"{root}: not a LeRobot dataset of version 3 with actions and states ({error})") from error
    for key, found in names.items():
        if found != STATE_NAMES:
            raise BadInput(
                f"{root}/meta/info.json: {key} is {found}, expected {STATE_NAMES}, radians and openness 0 to 1"
            )
    frames = tables.frames.sort_values("index")
    result = []
    for number, rows in frames.groupby("episode_index"):
        where = f"{folder.name}, episode {number}"
        result.append(_commands(column(rows, ACTION), column(rows, STATE)[0], rate_hz, where))
    if not result:
        raise BadInput(f"{root}: no episode in it; record one, or remove the folder")
    return result


def at_limits(joints_rad: np.ndarray, arms: Sequence[Arm]) -> np.ndarray:
    """Commands (T, 2, 6), those that pass a joint's limit by rounding alone moved onto it, as the cell moves them."""
    within = np.clip(joints_rad, *_limits(arms))
    return np.where(np.abs(joints_rad - within) <= ROUNDING_RAD, within, joints_rad)


def not_followed(
    origin: str, asked_rad: np.ndarray, reached_rad: np.ndarray, arms: Sequence[Arm]
) -> tuple[str, str] | None:
    """Class of failure and reason where the arms could not do what was asked of them; None where they could.

    Args:
        origin: of the commands.
        asked_rad: (T, 2, 6) commands, of `at_limits`.
        reached_rad: (T, 2, 6) where each command led.
        arms: in the order of `ARMS`.
    """
    beyond = np.abs(asked_rad - np.clip(asked_rad, *_limits(arms)))
    if beyond.max() > 0.0:
        place = np.unravel_index(beyond.argmax(), beyond.shape)
        lower, upper = (limits[place[1:]] for limits in _limits(arms))
        return "beyond joint limits", (
            f"demonstrations/{origin}: {_joint(place)} is asked to be at {asked_rad[place]:.6g} rad, "
            f"its limits are {lower:g} and {upper:g}; demonstrate it within them, or leave this episode out"
        )
    lag = np.abs(reached_rad - asked_rad)
    if lag.max() > LAG_RAD:
        place = np.unravel_index(lag.argmax(), lag.shape)
        speed = arms[place[1]].velocity_limit_rad_s[place[2]]
        return "too fast", (
            f"demonstrations/{origin}: {_joint(place)} is {lag[place]:.3g} rad behind its command, allowed {LAG_RAD}: "
            f"no joint moves faster than its limit, {speed:g} rad/s; demonstrate it slower, or leave this episode out"
        )
    return None


def _limits(arms: Sequence[Arm]) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper limits, (2, 6) each."""
    return np.stack([arm.lower_rad for arm in arms]), np.stack([arm.upper_rad for arm in arms])


def _joint(place: tuple[int, ...]) -> str:
    """Name of a joint, and when it is: of an index into (T, 2, 6)."""
    frame, side, joint = (int(number) for number in place)
    return f"{ARMS[side]}_joint_{joint + 1}_rad at frame {frame} ({frame / RATE_HZ:.2f} s, {RATE_HZ:g} frames a second)"


def _commands(actions: np.ndarray, state: np.ndarray, rate_hz: float, origin: str) -> Commands:
    if len(actions) < 2:
        raise BadInput(f"demonstrations/{origin}: one frame; a demonstration has more")
    whole = np.vstack([state, actions]).astype(float)
    if not np.isfinite(whole).all():
        row, place = np.argwhere(~np.isfinite(whole))[0]
        raise BadInput(
            f"demonstrations/{origin}: {STATE_NAMES[place]} is {whole[row, place]} at frame {max(row - 1, 0)}; mend it"
        )
    by_arm = whole.reshape(len(whole), 2, JOINT_COUNT + 1)
    if by_arm[..., -1].min() < -1e-6 or by_arm[..., -1].max() > 1.0 + 1e-6:
        low, high = by_arm[..., -1].min(), by_arm[..., -1].max()
        raise BadInput(f"demonstrations/{origin}: openness from {low:g} to {high:g}, expected 0 (closed) to 1 (open)")
    given_s = np.arange(len(whole)) / rate_hz
    asked_s = np.arange(1, int(given_s[-1] * RATE_HZ + 1e-6) + 1) / RATE_HZ
    even = np.stack([np.interp(asked_s, given_s, values) for values in whole.T], axis=1).reshape(-1, 2, JOINT_COUNT + 1)
    return Commands(
        origin=origin,
        start_joints_rad=by_arm[0, :, :-1],
        start_openness=by_arm[0, :, -1],
        joints_rad=even[..., :-1],
        openness=np.clip(even[..., -1], 0.0, 1.0),
    )
