"""The work of stage candidate_trajectories: attempts until there are enough, in a folder that a killed run goes on in."""

from __future__ import annotations

import functools
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from sim1.crew import finished, labour_together
from sim1.episode import RATE_HZ, Episode, read_episode, read_start
from sim1.motion.bench import Bench, facts
from sim1.motion.commands import Arms
from sim1.motion.pictures import draw_attempts
from sim1.progress import report
from sim1.quota import Quota, Row
from sim1.scene.description import read_scene
from sim1.stage import Facts, Inputs, only

if TYPE_CHECKING:
    from sim1.motion.stage import CandidateTrajectoriesConfig

SHOWN = 40  # attempts in the picture
WORTH_STARTING = 8  # attempts for each process


def generate(inputs: Inputs, garment: str, config: CandidateTrajectoriesConfig, out: Path) -> Facts:
    """Make, run, judge and write all attempts of one garment."""
    quotas = quotas_of(config, garment)
    total = sum(quota.run_count for quota in quotas)

    def tell(rows: dict[str, Row]) -> None:
        report(min(sum(row["ran"] for row in rows.values()), total), total, "candidates")

    prepare = functools.partial(Bench.of, inputs, garment, config)
    labour_together(out, quotas, prepare, processes_for(total, os.process_cpu_count() or 1), tell)
    rows = finished(out)
    write_tables(out, rows, read_start(only(inputs, "seed_demos")))
    write_limits(out, Arms.of_scene(read_scene(only(inputs, "scene"))))
    return facts(rows)


def processes_for(attempts: int, cores: int) -> int:
    """How many processes make so many attempts: a few are made before another process has started."""
    return max(1, min(cores, attempts // WORTH_STARTING))


def write_limits(out: Path, arms: Arms) -> None:
    """Write `limits.json`: what the episodes are checked against."""
    limits = {"joint_speed_rad_s": arms.arm.velocity_limit_rad_s.tolist()}
    (out / "limits.json").write_text(json.dumps(limits, indent=1, sort_keys=True) + "\n")


def fastest_share(episode: Episode, limit_rad_s: np.ndarray) -> float:
    """Fastest joint of an episode over its limit (6,), as commanded, from where the arms stood, and as measured."""
    commanded = np.concatenate([episode.joints_rad[:1], episode.command_joints_rad])
    steps = [np.abs(np.diff(way, axis=0)) for way in (commanded, episode.joints_rad)]
    return float((np.concatenate(steps) * RATE_HZ / limit_rad_s).max())


def quotas_of(config: CandidateTrajectoriesConfig, garment: str) -> tuple[Quota, Quota]:
    """How many attempts the stage makes of a garment."""
    tries, count = config.tries_per_candidate, config.candidate_count + config.more_of.get(garment, 0)
    return (
        Quota(
            series="",
            run_count=count,
            target=config.success_target,
            counted="success",
            run_limit=config.run_limit,
            try_limit=tries * max(count, config.run_limit),
        ),
        Quota(
            series="perturbed",
            run_count=config.perturbed_count,
            target=0,
            counted="success",
            run_limit=config.perturbed_count,
            try_limit=tries * config.perturbed_count,
        ),
    )


def write_tables(out: Path, rows: list[Row], start_m: np.ndarray) -> None:
    """Write `attempts.parquet` and `attempts.png` of attempts in order."""
    pd.DataFrame(rows).to_parquet(out / "attempts.parquet", index=False)
    picked = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), SHOWN)).round().astype(int))
    shown = [rows[index] for index in picked]
    ends = [_end_m(out / "episodes" / row["episode"]) if row["ran"] else None for row in shown]
    draw_attempts(out / "attempts.png", shown, ends, start_m, len(rows))


def _end_m(episode: Path) -> np.ndarray:
    """The garment in the last frame, (v, 3); a copy, because a view would keep all frames."""
    return read_episode(episode).garment_m[-1].copy()
