"""Demonstrations by the scripted expert (stage `seed_demos`)."""

from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import Field

from sim1.stage import Facts, Finding, Inputs, garment_of, only, random_stream, stage_config

if TYPE_CHECKING:
    from sim1.cloth.cell import Cell
    from sim1.episode import Episode


@stage_config
class SeedDemosConfig:
    """How many demonstrations, how they vary, and how finely the cloth is simulated."""

    demo_count: int = Field(2, ge=1)  # successes wanted
    attempts: int = Field(4, ge=1)  # at most this many tries; failures are kept and labelled
    seed: int = 0  # of the variation
    substeps: int = Field(8, ge=2, multiple_of=2)  # of the cloth solver per 1/30 s
    iterations: int = Field(5, ge=1)  # of the cloth solver per substep
    settle_s: float = Field(2.0, gt=0)  # at most, from the lying pose to rest
    rest_speed_m_s: float = Field(0.03, gt=0)  # slower than this is at rest
    grasp_std_m: float = Field(0.004, ge=0)  # spread of grasp points between demonstrations
    pace_std: float = Field(0.10, ge=0)  # spread of the logarithm of the pace
    replay_s: float = Field(
        2.5, gt=0
    )  # of one demonstration that is simulated again to prove that commands reproduce it
    queue: int = Field(2, ge=1)  # episodes that may wait for the writer thread


def seed_demos(inputs: Inputs, out: Path, config: SeedDemosConfig) -> Facts:
    """Settle the garment on the table, then demonstrate its task until enough runs succeeded.

    Writes `episodes/NNNN/` with `session.usdc`, `start.npz`, `task.json` and pictures. Stand-in for a person who teleoperates
    (SIM1, section on data collection): the expert is scripted, gripping is by finger contact and friction alone.

    Raises:
        BadInput: a damaged input, or a garment that does not come to rest on the table.
    """
    import json
    from dataclasses import asdict

    import numpy as np

    from sim1.cloth.cell import Cell, CellConfig
    from sim1.cloth.garment import read_garment_mesh
    from sim1.cloth.physics import read_physics
    from sim1.progress import report
    from sim1.robot.expert_task import SCHEMA, read_task
    from sim1.robot.expert_variation import Spread, draw_variation
    from sim1.robot.session import demonstrate, settle
    from sim1.robot.session_pictures import film_strip, outcome_picture
    from sim1.robot.session_writer import SessionWriter
    from sim1.scene.description import read_scene

    garment = garment_of(inputs)
    mesh = read_garment_mesh(only(inputs, "garment_mesh"))
    scene = read_scene(only(inputs, "scene"))
    physics = read_physics(only(inputs, "calibrated_physics") / "cell.yaml")
    task = read_task(_task_file(only(inputs, "task"), garment))
    numerics = CellConfig(substeps=config.substeps, iterations=config.iterations)
    cell = Cell(mesh, scene, physics, numerics, broken_to=out / "broken.npz")
    spread = Spread(grasp_m=config.grasp_std_m, pace=config.pace_std)
    report(0, config.attempts, "garment settles")
    start = settle(cell, longest_s=config.settle_s, rest_speed_m_s=config.rest_speed_m_s)
    np.savez(out / "start.npz", garment_m=start)
    (out / "task.json").write_text(json.dumps({"schema": SCHEMA, **asdict(task)}, indent=1, sort_keys=True) + "\n")

    rows, best = [], None
    with SessionWriter(out / "episodes", mesh.faces, scene, limit=config.queue) as writer:
        for attempt in range(config.attempts):
            variation = draw_variation(random_stream(config.seed, garment, "demonstration", attempt), spread)
            about = {
                "garment": garment,
                "kind": "demonstration",
                "seed": config.seed,
                "attempt": attempt,
                "sources": [],
            }
            episode = demonstrate(cell, task, start, variation, about)
            writer.put(f"{attempt:04d}", episode)
            rows.append(_row(attempt, episode.about, episode.frame_count))
            if best is None or (episode.about["success"] and not best.about["success"]):
                best = episode
            success_count = sum(row["success"] for row in rows)
            report(attempt + 1, config.attempts, f"{success_count} of {attempt + 1} folds succeeded")
            if success_count >= config.demo_count:
                break
    (out / "cell.json").write_text(
        json.dumps(_cell_facts(cell, best, config.replay_s), indent=1, sort_keys=True) + "\n"
    )
    film_strip(out / "1_film_strip.png", best, mesh.faces, title=f"{task.title} ({garment}): {_outcome(best.about)}")
    outcome_picture(out / "2_outcome.png", best, mesh.faces, task)
    return {
        "stand_in": "scripted expert in place of a person who teleoperates",
        "attempt_count": len(rows),
        "success_count": success_count,
        "vertex_count": len(mesh.rest_m),
        "duration_s": round(float(np.mean([row["duration_s"] for row in rows])), 2),
        "attempts": rows,
    }


def check_source_task(path: Path) -> None:
    """Raises BadInput where the task file is at fault: before any work, rather than in the middle of it."""
    from sim1.robot.expert_task import read_task

    read_task(path)


def check_seed_demos(artifact: Path) -> list[Finding]:
    """At least one success; joints within limits and speeds; finite; the first success replays to the same bytes."""
    from sim1.robot.session_check import findings

    return findings(artifact)


def _cell_facts(cell: "Cell", episode: "Episode", replay_s: float) -> dict:
    """What the check needs: settings, joint limits of either arm, and how the replay of one demonstration went."""
    from dataclasses import asdict

    import numpy as np

    from sim1.robot.session import replay, shortened

    part = shortened(episode, replay_s)
    again = replay(cell, part)
    return {
        "config": asdict(cell.config),
        "joint_lower_rad": cell.arms[0].lower_rad.tolist(),
        "joint_upper_rad": cell.arms[0].upper_rad.tolist(),
        "joint_speed_rad_s": cell.arms[0].velocity_limit_rad_s.tolist(),
        "replay": {
            "attempt": part.about["attempt"],
            "frame_count": part.frame_count,
            "largest_difference_m": float(np.abs(again.garment_m - part.garment_m).max()),
        },
    }


def _task_file(source: Path, garment: str) -> Path:
    return source / f"{garment}.yaml" if source.is_dir() else source


def _outcome(about: dict) -> str:
    return "folded" if about["success"] else f"failed, {about['failure']}"


def _row(attempt: int, about: dict, frame_count: int) -> dict:
    figures = about["figures"]
    return {
        "attempt": attempt,
        "success": bool(about["success"]),
        "failure": about["failure"] or "",
        "iou": round(figures["iou"], 3),
        "keypoint_error_mm": round(1000 * figures["keypoint_error_m"], 1),
        "height_mm": round(1000 * figures["height_m"], 1),
        "stretch": round(figures["stretch"], 3),
        "duration_s": round(frame_count / 30.0, 2),
    }
