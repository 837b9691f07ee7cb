"""The policy room against the rooms it stands on: LeRobot's writer, the simulated cell, the judge."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from PIL import Image

from sim1.cloth.garment import grid_towel
from sim1.cloth.physics import nominal_from_priors, write_physics
from sim1.dataset.keypoints import keypoint_indices
from sim1.dataset.stage import DatasetConfig, dataset
from sim1.episode import RATE_HZ, Episode, write_episode
from sim1.policy.episodes import read_keypoints, read_rate_hz, read_trajectories
from sim1.policy.stage import PolicyConfig, check_policy, policy
from sim1.policy.trials import open_bench
from sim1.policy.worlds import REALITY, SIMULATOR
from sim1.recording.stage import RealityConfig, reality
from sim1.render.appearance import SCHEMA
from sim1.scene.stage import SceneConfig, scene
from sim1.stage import BadInput

ROOT = Path(__file__).parents[2]
STRIDE, FRAMES = 3, 31
TOWEL = grid_towel(0.36, 0.45, 0.09)


def episode(number: int) -> Episode:
    """Arms that turn a little over a towel that lies still."""
    rng = np.random.default_rng(number)
    joints = (
        np.array([0.0, 1.2, 1.2, 0.0, 0.0, 0.0]) + 0.01 * rng.uniform(0, 1, (2, 6)) * np.arange(FRAMES)[:, None, None]
    )
    lying = TOWEL.vertices_m + np.array([0.0, 0.0, 0.002])
    return Episode(
        time_s=np.arange(FRAMES) / RATE_HZ,
        joints_rad=joints,
        openness=np.full((FRAMES, 2), 0.5),
        command_joints_rad=joints + 0.01,
        command_openness=np.full((FRAMES, 2), 0.5),
        garment_m=np.repeat(lying[None], FRAMES, axis=0).astype(np.float32),
        about={
            "garment": "towel",
            "task_text": "fold the towel",
            "sources": [f"{number:04d}"],
            "cell": {"substeps": 4, "iterations": 3},
        },
    )


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """Every input of the stage, made by the stages that make it, but for painted frames and arms that only wave."""
    folder = tmp_path_factory.mktemp("parts")
    names = (
        "garment_mesh",
        "scene",
        "calibrated_physics",
        "seed_demos",
        "reality",
        "real_demos",
        "rendered",
        "dataset",
    )
    place = {name: folder / name for name in names}
    for path in place.values():
        path.mkdir()
    corner = TOWEL.vertices_m[:, :2].min(axis=0)
    uv = ((TOWEL.vertices_m[:, :2] - corner) / np.ptp(TOWEL.vertices_m[:, :2], axis=0))[TOWEL.faces]
    mesh = {"vertices_m": TOWEL.vertices_m, "faces": TOWEL.faces, "rest_m": TOWEL.rest_m, "uv": uv}
    np.savez(place["garment_mesh"] / "mesh.npz", **mesh)
    Image.fromarray(np.full((8, 8, 3), 180, np.uint8)).save(place["garment_mesh"] / "texture.png")
    needs = {
        "garment_mesh": place["garment_mesh"],
        "robot": ROOT / "data" / "robot",
        "environment": ROOT / "data" / "environment",
    }
    scene({name: {"towel": path} for name, path in needs.items()}, place["scene"], SceneConfig())
    fabric = yaml.safe_load((ROOT / "data" / "garments" / "towel.yaml").read_text())["fabric"]
    write_physics(place["calibrated_physics"] / "cell.yaml", nominal_from_priors(fabric))
    source = {"garment": {"towel": ROOT / "data" / "garments" / "towel.yaml"}}
    reality(source, place["reality"], RealityConfig(effects={"air_drag": 1.0}))
    task = yaml.safe_load((ROOT / "data" / "tasks" / "towel.yaml").read_text())
    (place["seed_demos"] / "task.json").write_text(json.dumps(task))
    np.savez(place["seed_demos"] / "start.npz", garment_m=episode(0).garment_m[0])
    (place["real_demos"] / "none.json").write_text('{"why": "nobody asked"}')
    np.savez(place["rendered"] / "garment.npz", rest_m=TOWEL.rest_m, faces=TOWEL.faces)
    for number in range(3):
        write_episode(place["seed_demos"] / "episodes" / f"{number:04d}", episode(number))
        clip = place["rendered"] / "episodes" / f"{number:04d}"
        write_episode(clip, episode(number))
        for appearance in range(2):
            paint_clip(clip / f"v{appearance}", shade=40 + 50 * number + 20 * appearance)
    dataset(
        {"robot": {"": ROOT / "data" / "robot"}, "rendered_episodes": {"towel": place["rendered"]}},
        place["dataset"],
        DatasetConfig(),
    )
    stages = ("garment_mesh", "scene", "calibrated_physics", "seed_demos", "reality", "real_demos")
    given = {name: {"towel": place[name]} for name in stages}
    return {**given, "dataset": {"": place["dataset"]}}


def paint_clip(folder: Path, shade: int) -> None:
    (folder / "head").mkdir(parents=True)
    count = len(range(0, FRAMES, STRIDE))
    look = {sort: {"name": sort} for sort in ("fabric", "table", "room")}
    camera = {"width": 64, "height": 48, "fy_px": 40.0, "camera_to_world": np.eye(4).tolist(), "moves": False}
    about = {"schema": SCHEMA, "rate_hz": 10, "stride": STRIDE, "frame_count": count, "appearance": look}
    about["cameras"] = {"head": camera}
    (folder / "appearance.json").write_text(json.dumps(about))
    for frame in range(count):
        Image.fromarray(np.full((48, 64, 3), shade + frame, np.uint8)).save(folder / "head" / f"{frame:06d}.png")


def test_what_lerobot_wrote_is_what_the_policy_reads(inputs):
    folder = inputs["dataset"][""]
    assert read_rate_hz(folder) == 10
    np.testing.assert_array_equal(read_keypoints(folder, "towel"), keypoint_indices(TOWEL.rest_m, 12))
    read = read_trajectories(folder)
    assert [item.name for item in read] == ["0000", "0001", "0002"]
    for number, item in enumerate(read):
        truth = episode(number)
        np.testing.assert_array_equal(item.state, truth.state()[::STRIDE])
        np.testing.assert_array_equal(item.action, truth.action_until_next(STRIDE))
        points = truth.garment_m[::STRIDE, keypoint_indices(TOWEL.rest_m, 12)]
        np.testing.assert_array_equal(item.keypoints, points.reshape(len(item.state), -1))
        assert item.sources == {f"{number:04d}"}


def test_trials_run_with_the_numerics_of_the_demonstrations(inputs):
    bench = open_bench(inputs, "towel", "simulator")
    assert (bench.cell.config.substeps, bench.cell.config.iterations) == (4, 3)
    np.testing.assert_array_equal(bench.start.joints_rad, episode(0).joints_rad[0])


def test_in_the_stand_in_reality_the_fabric_the_air_and_the_steps_are_others(inputs):
    trained, real = (open_bench(inputs, "towel", world) for world in ("simulator", "reality"))
    assert (trained.world, real.world) == (SIMULATOR, REALITY)
    assert real.cell.config.substeps == 2 * trained.cell.config.substeps
    assert [effect["name"] for effect in real.cell.physics.effects] == ["air_drag"]
    values = [bench.cell.physics.stretch_n_m.value for bench in (trained, real)]
    assert abs(np.log(values[0] / values[1])) > 0.02


def test_where_reality_is_real_cloth_trials_are_in_the_simulator_and_say_so(inputs, tmp_path):
    bundle = {"recordings": {"towel": tmp_path}, "garment": {"towel": tmp_path}}
    reality(bundle, tmp_path, RealityConfig())
    assert open_bench({**inputs, "reality": {"towel": tmp_path}}, "towel", "reality").world == SIMULATOR


def test_a_trial_in_the_stand_in_reality_begins_as_real_demonstrations_do_whatever_made_the_training_data(
    inputs, tmp_path
):
    lying = episode(0).garment_m[0] + np.float32(0.003)
    np.savez(tmp_path / "start.npz", garment_m=lying)
    given = {**inputs, "real_demos": {"towel": tmp_path}}
    for friction_factor in (1.0, 0.6):
        bench = open_bench(given, "towel", "reality", friction_factor)
        np.testing.assert_array_equal(bench.start.garment_m, lying)
    trained = open_bench(given, "towel", "simulator").start.garment_m
    np.testing.assert_array_equal(trained, episode(0).garment_m[0])
    with pytest.raises(BadInput, match=r"start\.npz: not a readable start .* make the demonstrations again"):
        open_bench({**given, "real_demos": {"towel": tmp_path / "lost"}}, "towel", "reality")


def test_a_garment_that_was_not_demonstrated_there_is_laid_down_as_its_fabric_lies_there(inputs, tmp_path):
    demos = shutil.copytree(inputs["seed_demos"]["towel"], tmp_path / "demos")
    np.savez(demos / "start.npz", garment_m=episode(0).garment_m[0] + np.float32(0.05))
    given = {**inputs, "seed_demos": {"towel": demos}}
    bench, slippery = (open_bench(given, "towel", "reality", factor) for factor in (1.0, 0.6))
    cell, start = bench.cell, bench.start
    np.testing.assert_array_equal(slippery.start.garment_m, start.garment_m)  # friction changes once it lies
    assert np.ptp(start.garment_m[:, 2]) < 0.002  # on the table, not in the air where the training data begin
    assert start.garment_m[:, 2].max() < 0.01
    cell.reset(start.garment_m, start.joints_rad, start.openness)
    for _ in range(5):
        cell.step(start.joints_rad, start.openness)
    assert np.abs(cell.garment_m - start.garment_m).max() < 5e-4  # and it lies still


def test_demonstrations_that_hide_their_numerics_are_named(tmp_path, inputs):
    demos = tmp_path / "demos"
    shutil.copytree(inputs["seed_demos"]["towel"], demos)
    path = demos / "episodes" / "0000" / "episode.json"
    about = json.loads(path.read_text())
    del about["cell"]
    path.write_text(json.dumps(about))
    with pytest.raises(BadInput, match=r"episodes/0000/episode\.json.*settings of the cell"):
        open_bench({**inputs, "seed_demos": {"towel": demos}}, "towel", "simulator")


CONFIG = PolicyConfig(
    sizes=(2,),
    seeds=(0,),
    steps=30,
    width=16,
    depth=1,
    trial_count=1,
    shifts=("spatial",),
    time_factor=0.5,
    processes=1,
)


@pytest.mark.slow
def test_two_processes_write_the_bytes_that_one_writes(tmp_path, inputs):
    contents = []
    for processes in (1, 2):
        out = tmp_path / str(processes)
        out.mkdir()
        policy(inputs, out, replace(CONFIG, processes=processes, trial_count=3, shifts=("in-domain", "friction")))
        contents.append({path.relative_to(out): path.read_bytes() for path in out.rglob("*") if path.is_file()})
    assert contents[0] == contents[1]


def test_a_policy_drives_the_simulated_cell_and_is_judged(tmp_path, inputs):
    facts = policy(inputs, tmp_path, CONFIG)
    assert [finding.name for finding in check_policy(tmp_path) if not finding.passed and finding.blocking] == []
    trial = pd.read_parquet(tmp_path / "evaluation.parquet").iloc[0]
    assert facts["success_count"] == 0
    assert trial["failure"] == "missed grasp"  # nobody lifted anything
    figures = json.loads(trial["figures"])
    assert figures["area_ratio"] == pytest.approx(1, abs=0.05)
    assert (tmp_path / "trials_spatial.png").exists()
