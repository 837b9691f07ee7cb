"""Small artifacts with a sheet that is folded over, well or badly, by formula: no simulation."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

from sim1.cloth.garment import grid_towel
from sim1.episode import Episode, write_episode
from sim1.motion.placement import planar
from sim1.scene.description import Camera, Scene, write_scene
from sim1.validity.clips import head_clip, write_clip
from sim1.validity.stage import ValidTrajectoriesConfig, VideoDiscriminatorConfig

SHEET = grid_towel(0.30, 0.24, 0.03)
FRAMES = 40
TASK = {
    "schema": "sim1.task/1",
    "title": "fold in half",
    "keypoints": {"near_left": [-1.0, 1.0], "near_right": [-1.0, -1.0], "far_left": [1.0, 1.0]},
    "steps": [
        {
            "name": "near onto far",
            "left": {"grasp": "near_left", "fold": {"axis": "x", "at": 0.5}},
            "right": {"grasp": "near_right", "fold": {"axis": "x", "at": 0.5}},
        }
    ],
}


def folding(share: float, rng: np.random.Generator, turn_rad: float = 0.0) -> np.ndarray:
    """(T, v, 3): the near half turns over by `share` of a half turn, on a sheet that was laid down turned."""
    sheet = np.array(SHEET.rest_m)
    near = sheet[:, 0] < 0
    motion = []
    for s in np.linspace(0, 1, FRAMES):
        angle = np.pi * share * min(1.25 * s, 1.0)
        frame = sheet.copy()
        frame[near, 0] = sheet[near, 0] * np.cos(angle)
        frame[near, 2] = -sheet[near, 0] * np.sin(angle) + 0.002
        motion.append(frame)
    place = planar(rng.uniform(-0.03, 0.03, 2), turn_rad, np.zeros(3))
    moved = np.array(motion) + rng.normal(0, 2e-4, (FRAMES, 1, 3))
    return (moved @ place[:3, :3].T + place[:3, 3]).astype(np.float32)


def an_episode(garment_m: np.ndarray, **about) -> Episode:
    count = len(garment_m)
    return Episode(
        time_s=np.arange(count) / 30.0,
        joints_rad=np.zeros((count, 2, 6)),
        openness=np.ones((count, 2)),
        command_joints_rad=np.zeros((count, 2, 6)),
        command_openness=np.ones((count, 2)),
        garment_m=garment_m,
        about=about,
    )


def a_scene(folder: Path) -> Scene:
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("table.obj", "robot.urdf"):
        (folder / name).write_text("")
    pose = np.eye(4)
    pose[2, 3] = 1.0
    return Scene(
        table_mesh=folder / "table.obj",
        table_size_m=np.array([0.8, 1.2, 0.03]),
        table_top_m=0.0,
        urdf=folder / "robot.urdf",
        base_to_world={"left": np.eye(4), "right": np.eye(4)},
        home_rad={"left": np.zeros(6), "right": np.zeros(6)},
        garment_place=np.eye(4),
        cameras={"head": Camera(width=640, height=480, fy_px=600.0, pose=pose)},
        wrist_cameras={},
    )


def make_artifacts(root: Path, demo_shares: list[float], candidate_shares: list[float]) -> dict[str, dict[str, Path]]:
    """Inputs of the validity stages; a fold by more than nine tenths is a success."""
    rng = np.random.default_rng(11)
    folders = {name: root / name for name in ("garment_mesh", "scene", "seed_demos", "candidate_trajectories")}
    folders["garment_mesh"].mkdir(parents=True)
    np.savez(folders["garment_mesh"] / "mesh.npz", vertices_m=SHEET.vertices_m, faces=SHEET.faces, rest_m=SHEET.rest_m)
    scene = a_scene(folders["scene"])
    write_scene(folders["scene"], scene)
    folders["seed_demos"].mkdir()
    np.savez(folders["seed_demos"] / "start.npz", garment_m=SHEET.rest_m.astype(np.float32))
    (folders["seed_demos"] / "task.json").write_text(json.dumps(TASK))
    for index, share in enumerate(demo_shares):
        about = {"success": share > 0.9, "failure": None if share > 0.9 else "not folded"}
        write_episode(folders["seed_demos"] / f"episodes/{index:04d}", an_episode(folding(share, rng), **about))
    rows = []
    for index, share in enumerate(candidate_shares):
        name, success = f"{index:04d}", share > 0.9
        source = f"{index % max(len(demo_shares), 1):04d}"
        garment = folding(share, rng, turn_rad=rng.uniform(-0.2, 0.2))
        folder = folders["candidate_trajectories"] / "episodes" / name
        failure = None if success else "not folded"
        episode = an_episode(garment, success=success, failure=failure, sources=[source], perturbed=False)
        write_episode(folder, episode)
        write_clip(folder, head_clip(garment, SHEET.faces, scene, rate_hz=10.0, width=32, height=32))
        rows.append(
            {"attempt": index, "episode": name, "perturbed": False, "ran": True, "success": success, "failure": failure}
        )
    pd.DataFrame(rows).to_parquet(folders["candidate_trajectories"] / "attempts.parquet", index=False)
    return {name: {"sheet": folder} for name, folder in folders.items()}


USUAL = ValidTrajectoriesConfig()
TESTED = 2  # of three demonstrations with as many failures each
TINY = VideoDiscriminatorConfig(step_count=6, frame_count=4, frame_width=32, frame_height=32, batch_size=4, width=16)


def run(stage, inputs, out, config):
    out.mkdir()
    return stage(inputs, out, config)


def names(findings, passed):
    return {finding.name for finding in findings if finding.passed is passed}
