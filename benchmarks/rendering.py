"""Blender frames of both arms over a towel.

One of 160 x 120 at 16 samples in furnished rooms against one in an empty room in even light; and many of the default size by a process
per core with a thread each against one process with all threads.
"""

import os
import resource
import tempfile
import time
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from benchmarks.timing import against
from sim1.cloth.garment import grid_towel
from sim1.render.appearance import Appearance, Glow
from sim1.render.blender import run_blender
from sim1.render.job import SETTINGS, Clip, Job, write_cameras, write_motion
from sim1.render.looks.blocks import Block
from sim1.render.looks.draw import draw_appearance, read_looks
from sim1.render.robot_visuals import link_motion, part_poses, robot_parts
from sim1.render.stage import RenderConfig
from sim1.robot.kinematics import Arm
from sim1.scene.environment import look_at
from sim1.stage import random_stream

DATA = Path(__file__).parents[1] / "data"
CONFIG = RenderConfig(width=160, height=120, samples=16, device="cpu", workers=1)
ROOMS = 3  # appearances that the mean is taken over
FRAMES = 6  # of each; one costs setting up as well, the others are counted
ROUNDS = 2
CORES = os.process_cpu_count() or 1
SMALL = RenderConfig(device="cpu")
ONE, MANY = (replace(SMALL, workers=workers, threads=CORES // workers) for workers in (1, CORES))
CLIPS = CORES + 1  # they cannot be dealt out evenly
CLIP_FRAMES = 24
EYE_M, FY_OVER_HEIGHT = (-0.52, 0.0, 0.92), 615.0 / 480.0  # the head camera's


def compare() -> dict[str, Any]:
    """Least seconds a frame of both, and CPU seconds; starting Blender and setting up an appearance are not counted."""
    rooms = _rooms(ROOMS)
    ways = ([_empty(look) for look in rooms], rooms)
    found = [[seconds_a_frame(way) for way in ways] for _ in range(ROUNDS)]
    (empty, empty_cpu), (furnished, furnished_cpu) = np.min(found, axis=0)
    return {
        "what": f"a frame of {CONFIG.width} x {CONFIG.height} at {CONFIG.samples} samples in a furnished room",
        "against": "the same in an empty room in even light",
        "seconds": round(float(furnished), 3),
        "seconds_against": round(float(empty), 3),
        "ratio": round(float(furnished / empty), 3),
        "cpu_seconds": round(float(furnished_cpu), 3),
        "cpu_seconds_against": round(float(empty_cpu), 3),
    }


def compare_workers() -> dict[str, Any]:
    """Both render the same clips, what it takes to start and to set up clips included."""
    rooms = _rooms(CLIPS)
    return against(
        f"{CLIPS} clips of {CLIP_FRAMES} frames of {SMALL.width} x {SMALL.height} at {SMALL.samples} samples: workers "
        f"{MANY.workers}, threads {MANY.threads}",
        lambda: _seconds(rooms, CLIP_FRAMES, MANY),
        f"workers {ONE.workers}, threads {ONE.threads}",
        lambda: _seconds(rooms, CLIP_FRAMES, ONE),
        rounds=ROUNDS,
    )


def seconds_a_frame(looks: list[Appearance]) -> tuple[float, float]:
    """Wall-clock and CPU seconds of one frame more."""
    few, many = (_seconds(looks, count, CONFIG) for count in (1, FRAMES))
    return tuple((np.array(many) - few) / (len(looks) * (FRAMES - 1)))


def _rooms(count: int) -> list[Appearance]:
    looks = read_looks(DATA / "appearance")
    return [
        draw_appearance(
            partial(random_stream, 0, "benchmark", number),
            looks,
            scanned=(0.5, 0.5, 0.5),
            scanned_share=0.0,
            elevation_jitter_rad=0.0,
        )
        for number in range(count)
    ]


def _empty(look: Appearance) -> Appearance:
    even = Glow(shape=Block(kind="ambient", values={}), bearing_rad=0.0, color=(1.0, 1.0, 1.0), level=1.0)
    return replace(look, room=replace(look.room, furniture=(), glows=(even,), lamps=()))


def _seconds(looks: list[Appearance], frame_count: int, config: RenderConfig) -> tuple[float, float]:
    with tempfile.TemporaryDirectory() as temporary:
        job = Path(temporary) / "job"
        _write_job(job, looks, frame_count, config)
        began, cpu = time.perf_counter(), _cpu_seconds()
        run_blender(job, Path(temporary) / "out")
        return time.perf_counter() - began, _cpu_seconds() - cpu


def _cpu_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _write_job(folder: Path, looks: list[Appearance], frame_count: int, config: RenderConfig) -> None:
    towel = grid_towel(0.5, 0.4, 0.02)
    arm = Arm.from_urdf(DATA / "robot" / "robot.urdf")
    parts = robot_parts(arm)
    bases = {name: np.eye(4) for name in ("left", "right")}
    bases["left"][:3, 3], bases["right"][:3, 3] = (-0.35, 0.3, 0.0), (-0.35, -0.3, 0.0)
    joints_rad = np.full((frame_count, 2, 6), 0.0)
    joints_rad[..., 1:3] = 1.2
    joints_rad[..., 0] = np.linspace(0.0, 0.4, frame_count)[:, None]
    links = link_motion(arm, bases, joints_rad=joints_rad, openness=np.zeros((frame_count, 2)))
    garment_m = np.repeat(towel.rest_m[None] + [0.0, 0.0, 0.004], frame_count, axis=0)
    garment_m[..., 2] += np.linspace(0.0, 0.1, frame_count)[:, None] * np.clip(towel.rest_m[:, 0], 0.0, None)
    table = trimesh.creation.box((0.8, 1.2, 0.03))
    pose = look_at(np.array(EYE_M), np.zeros(3), np.array([0.0, 0.0, 1.0]))
    clips = [
        Clip(episode="0000", variant=k, frame_count=frame_count, stride=1, appearance=look)
        for k, look in enumerate(looks)
    ]
    Job(
        folder=folder,
        texture=folder,  # no appearance shows a measured texture
        settings={key: asdict(config)[key] for key in SETTINGS},
        part_colors=[part.color for part in parts],
        fy_over_height={"head": FY_OVER_HEIGHT},
        clips=clips,
    ).write(
        {
            "faces": towel.faces,
            "uv": towel.rest_m[towel.faces][..., :2],
            "pattern_m": towel.rest_m[:, :2],
            "table_vertices": np.asarray(table.vertices) - [0.0, 0.0, 0.018],
            "table_faces": np.asarray(table.faces),
        }
        | {f"part_{k}_vertices": part.vertices_m for k, part in enumerate(parts)}
        | {f"part_{k}_faces": part.faces for k, part in enumerate(parts)}
    )
    write_motion(folder, clips[0], {"garment_m": garment_m, "parts": part_poses(parts, links)})
    for clip in clips:
        write_cameras(folder, clip, {"head": np.repeat(pose[None], frame_count, axis=0)})
