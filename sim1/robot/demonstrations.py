"""Demonstrations: the garment settles, a person's commands or the expert fold it, everything is written."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from sim1.cloth.cell import Cell, CellConfig
from sim1.cloth.garment import read_garment_mesh
from sim1.cloth.physics import read_physics
from sim1.episode import Episode
from sim1.motion.placement import random_placement
from sim1.progress import report
from sim1.robot.expert_task import SCHEMA, Task, read_task
from sim1.robot.expert_variation import Spread, draw_variation
from sim1.robot.pad_slip import pad_slip_m
from sim1.robot.session import demonstrate, follow, replay, settle, shortened
from sim1.robot.session_pictures import film_strip, outcome_picture
from sim1.robot.session_writer import SessionWriter
from sim1.robot.stage import SeedDemosConfig
from sim1.robot.teleoperation import read_commands
from sim1.scene.description import read_scene
from sim1.stage import BadInput, Facts, Inputs, garment_of, only, random_stream


def record(inputs: Inputs, out: Path, config: SeedDemosConfig, *, physics: Path, finer_mesh: bool = False) -> Facts:
    """Demonstrate in a cell with the fabric in the file `physics`, on a finer mesh of the garment if so asked; see `seed_demos`.

    Where a person's demonstrations are given, all of them are followed, and the expert does nothing; else the expert tries until
    enough succeeded.

    Raises:
        BadInput: a damaged input, or a garment that does not come to rest on the table.
    """
    garment = garment_of(inputs)
    mesh = read_garment_mesh(only(inputs, "garment_mesh"))
    scene = read_scene(only(inputs, "scene"))
    task = read_task(_task_file(only(inputs, "task"), garment))
    numerics = CellConfig(substeps=config.substeps, iterations=config.iterations, finer_mesh=finer_mesh)
    cell = Cell(mesh, scene, read_physics(physics), numerics, broken_to=out / "broken.npz")
    given = read_commands(only(inputs, "demonstrations")) if inputs.get("demonstrations") else []
    most = len(given) or config.attempts
    report(0, most, "garment settles")
    try:
        start = settle(cell, longest_s=config.settle_s, rest_speed_m_s=config.rest_speed_m_s)
    except BadInput as error:
        raise BadInput(f"{only(inputs, 'garment_mesh')} in {only(inputs, 'scene')}: {error}") from error
    np.savez(out / "start.npz", garment_m=start)
    (out / "task.json").write_text(json.dumps({"schema": SCHEMA, **asdict(task)}, indent=1, sort_keys=True) + "\n")

    rows, best = [], None
    with SessionWriter(out / "episodes", mesh.faces, scene, limit=config.queue) as writer:
        for attempt in range(most):
            about = {
                "garment": garment,
                "kind": "demonstration",
                "task_text": task.instruction(garment),
                "seed": config.seed,
                "attempt": attempt,
                "sources": [],
            }
            if given:
                one = given[attempt]
                episode = follow(cell, task, start, one, {**about, "commands_of": one.origin})
            else:
                episode = _by_expert(cell, task, start, config, about)
            writer.put(f"{attempt:04d}", episode)
            rows.append(_row(attempt, episode, cell))
            if best is None or (episode.about["success"] and not best.about["success"]):
                best = episode
            success_count = sum(row["success"] for row in rows)
            report(attempt + 1, most, f"{success_count} of {attempt + 1} folds succeeded")
            if not given and success_count >= config.demo_count:
                break
    (out / "cell.json").write_text(
        json.dumps(_cell_facts(cell, best, config.replay_s), indent=1, sort_keys=True) + "\n"
    )
    film_strip(out / "1_film_strip.png", best, mesh.faces, title=f"{task.title} ({garment}): {_outcome(best.about)}")
    outcome_picture(out / "2_outcome.png", best, mesh.faces, task)
    return {
        **({} if given else {"stand_in": "scripted expert in place of a person who teleoperates"}),
        "commands_by": "a person" if given else "a scripted expert",
        "attempt_count": len(rows),
        "success_count": success_count,
        "vertex_count": len(mesh.rest_m),
        "duration_s": round(float(np.mean([row["duration_s"] for row in rows])), 2),
        **_grasp_facts([row for row in rows if row["success"]]),
        "attempts": rows,
    }


def _by_expert(cell: Cell, task: Task, start_m: np.ndarray, config: SeedDemosConfig, about: dict[str, Any]) -> Episode:
    stream = random_stream(config.seed, about["garment"], "demonstration", about["attempt"])
    variation = draw_variation(stream, Spread(grasp_m=config.grasp_std_m, pace=config.pace_std))
    return demonstrate(cell, task, _laid(start_m, config.laid_m, stream), variation, about)


def _grasp_facts(folded: list[dict]) -> dict[str, float]:
    """How well cloth was held and what of it passes through itself: the largest of the attempts that folded it."""
    slips = [row["pad_slip_mm"] for row in folded if row["pad_slip_mm"] is not None]
    crossings = [row["crossing_count"] for row in folded]
    return {"largest_pad_slip_mm": max(slips)} | {"largest_crossing_count": max(crossings)} if slips else {}


def _laid(start: np.ndarray, radius_m: float, stream: np.random.Generator) -> np.ndarray:
    """The garment (v, 3) laid down somewhere within a radius, unturned: the task's fold lines lie along the world's axes."""
    if not radius_m:
        return start
    place = random_placement(stream, radius_m, 0.0, start.mean(axis=0))
    return (start @ place[:3, :3].T + place[:3, 3]).astype(start.dtype)


def _cell_facts(cell: Cell, episode: Episode, replay_s: float) -> dict:
    """What the check needs: settings, joint limits of either arm, and how the replay of one demonstration went."""
    part = shortened(episode, replay_s)
    again = replay(cell, part)
    count = min(again.frame_count, part.frame_count)
    return {
        "config": asdict(cell.config),
        "joint_lower_rad": cell.arms[0].lower_rad.tolist(),
        "joint_upper_rad": cell.arms[0].upper_rad.tolist(),
        "joint_speed_rad_s": cell.arms[0].velocity_limit_rad_s.tolist(),
        "replay": {
            "attempt": part.about["attempt"],
            "recorded_count": part.frame_count,
            "frame_count": again.frame_count,
            "largest_difference_m": float(np.abs(again.garment_m[:count] - part.garment_m[:count]).max()),
        },
    }


def _task_file(source: Path, garment: str) -> Path:
    return source / f"{garment}.yaml" if source.is_dir() else source


def _outcome(about: dict) -> str:
    return "folded" if about["success"] else f"failed, {about['failure']}"


def _row(attempt: int, episode: Episode, cell: Cell) -> dict:
    about, figures = episode.about, episode.about["figures"]
    tools = np.stack([cell.tool_poses(joints) for joints in episode.joints_rad])
    config = cell.config
    slip_m = pad_slip_m(
        episode.garment_m, tools, episode.openness, width_m=config.finger_width_m, length_m=config.finger_length_m
    )
    return {
        "attempt": attempt,
        "success": bool(about["success"]),
        "failure": about["failure"] or "",
        "iou": round(figures["iou"], 3),
        "keypoint_error_mm": round(1000 * figures["keypoint_error_m"], 1),
        "height_mm": round(1000 * figures["height_m"], 1),
        "stretch": round(figures["stretch"], 3),
        "crossing_count": int(figures["crossing_count"]),  # edges of the garment that pass through a face of it
        "pad_slip_mm": None if slip_m is None else round(1000 * slip_m, 2),
        "duration_s": round(episode.frame_count / 30.0, 2),
    }
