"""Checks of recorded demonstrations against what a robot and a garment can do."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.episode import RATE_HZ, Episode, episode_folders, read_episode
from sim1.robot.teleoperation import LAG_RAD
from sim1.stage import Finding
from sim1.validity.success import CUT_SHORT

NOTES = 3  # of attempts that failed, where all did


@dataclass(frozen=True, kw_only=True)
class _Run:
    """What is measured of one episode."""

    name: str  # of its folder
    success: bool
    whole: bool  # carried out to its end, as it was asked for
    note: str  # why it was not, for whom it concerns
    beyond_rad: float  # joints beyond their limits
    asked_beyond_rad: float  # commands beyond them
    speed_share: float  # fastest joint over its limit
    lag_rad: float  # largest of a joint behind its command
    end_lowest_m: float  # lowest vertex in the last frame
    lowest_m: float  # and at any time


def _measured(name: str, episode: Episode, lower: np.ndarray, upper: np.ndarray, speed: np.ndarray) -> _Run:
    joints, commands = episode.joints_rad, episode.command_joints_rad
    return _Run(
        name=name,
        success=bool(episode.about["success"]),
        whole=episode.about["failure"] not in CUT_SHORT,
        note=episode.about["note"],
        beyond_rad=float(np.maximum(lower - joints, joints - upper).max()),
        asked_beyond_rad=float(np.maximum(lower - commands, commands - upper).max()),
        speed_share=float((np.abs(np.diff(joints, axis=0)) * RATE_HZ / speed).max(initial=0.0)),
        lag_rad=float(np.abs(joints[1:] - commands[:-1]).max(initial=0.0)),
        end_lowest_m=float(episode.garment_m[-1, :, 2].min()),
        lowest_m=float(episode.garment_m[..., 2].min()),
    )


def findings(artifact: Path) -> list[Finding]:
    """Findings on a `seed_demos` artifact."""
    cell = json.loads((artifact / "cell.json").read_text())
    limits = [np.array(cell[name]) for name in ("joint_lower_rad", "joint_upper_rad", "joint_speed_rad_s")]
    folders = episode_folders(artifact)
    # One by one: together they fill a memory.
    runs = [_measured(folder.name, read_episode(folder), *limits) for folder in folders]
    success_count = sum(run.success for run in runs)
    beyond, fastest = max(run.beyond_rad for run in runs), max(run.speed_share for run in runs)
    whole = [run for run in runs if run.whole]  # of the others their failure says what was asked in vain
    asked, asking = max(((run.asked_beyond_rad, run.name) for run in whole), default=(0.0, "-"))
    lag, lagging = max(((run.lag_rad, run.name) for run in whole), default=(0.0, "-"))
    notes = [f"; attempt {run.name}: {run.note}" for run in runs if run.note and not success_count]
    at_rest = min((run.end_lowest_m for run in runs if run.success), default=0.0)
    pressed = min((run.lowest_m for run in runs if run.success), default=0.0)
    missing = [folder.name for folder in folders if not (folder / "session.usdc").is_file()]
    again = cell["replay"]
    return [
        Finding(
            name="a_demonstration_succeeds",
            passed=success_count > 0,
            detail=f"{success_count} of {len(runs)} attempts folded the garment, at least 1 needed"
            + "".join(notes[:NOTES]),
        ),
        Finding(
            name="replay_reproduces_demonstration",
            passed=0 < again["frame_count"] == again["recorded_count"] and again["largest_difference_m"] == 0.0,
            detail=f"{again['frame_count']} of {again['recorded_count']} frames of attempt {again['attempt']} again from its"
            f" commands: largest difference of a vertex {again['largest_difference_m']} m, limit 0",
        ),
        Finding(
            name="joints_within_limits",
            passed=max(beyond, asked) <= 1e-9,
            detail=f"measured {beyond:.3g} rad and commanded {asked:.3g} rad (attempt {asking}) beyond the limits,"
            " allowed 0",
        ),
        Finding(
            name="joint_speeds_within_limits",
            passed=fastest <= 1.0 + 1e-6,
            detail=f"fastest joint at {100 * fastest:.0f} % of its speed limit",
        ),
        Finding(
            name="arms_follow_commands",
            passed=lag <= LAG_RAD,
            detail=f"largest lag of a joint behind its command {lag:.4f} rad (attempt {lagging}), limit {LAG_RAD}",
        ),
        Finding(
            name="garment_lies_on_table",
            passed=at_rest > -0.005,
            detail=f"lowest vertex at the end of successful runs at {1000 * at_rest:.1f} mm, limit -5 mm",
        ),
        Finding(
            name="fingers_hardly_press_garment_into_table",
            passed=pressed > -0.008,
            detail=f"lowest vertex at any time of successful runs at {1000 * pressed:.1f} mm, limit -8 mm: the contact with"
            " the table is a soft penalty",
            blocking=False,
        ),
        Finding(
            name="sessions_as_usd",
            passed=not missing,
            detail=f"episodes without session.usdc: {missing or 'none'}",
            blocking=False,
        ),
    ]
