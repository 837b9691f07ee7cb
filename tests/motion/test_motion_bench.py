"""What the record of a generated episode says of it."""

from dataclasses import asdict, replace
from types import SimpleNamespace

import numpy as np
import pytest
from motion_synthetic import HOME, a_demo, a_model

import sim1.motion.bench
from sim1.cloth.config import CellConfig
from sim1.cloth.physics import nominal_from_priors, physics_of_record
from sim1.episode import RATE_HZ, Episode, read_episode, write_episode
from sim1.motion.assembly import Attempt, Source
from sim1.motion.bench import Bench, read_source
from sim1.motion.stage import CandidateTrajectoriesConfig
from sim1.quota import Ticket
from sim1.robot.expert_task import read_task

TASK = """
schema: sim1.task/1
title: Turn over
text: turn the towel over
keypoints: {near_left: [-1.0, 1.0], near_right: [-1.0, -1.0]}
steps:
  - name: over
    left: {grasp: near_left, fold: {axis: x, at: 0.7}}
    right: {grasp: near_right, fold: {axis: x, at: 0.7}}
"""


FABRIC = replace(
    nominal_from_priors(
        {
            "area_density_kg_m2": {"value": 0.3},
            "thickness_m": {"value": 0.002},
            "stretch_n_m": {"value": 400.0},
            "poisson": {"value": 0.3},
            "bending_n_m": {"value": 5.0e-5},
            "damping_s": {"value": 1.0e-3},
        }
    ),
    effects=({"name": "air_drag", "parameters": {"c_normal": {"value": 1.2, "ci95": [1.0, 1.4], "unit": "1"}}},),
)


@pytest.fixture
def record(tmp_path, monkeypatch, arms, home) -> dict:
    """Of an attempt that stood still for three frames."""
    still = np.repeat(HOME[None], 3, axis=0)
    episode = Episode(
        time_s=np.arange(3) / RATE_HZ,
        joints_rad=still,
        openness=np.ones((3, 2)),
        command_joints_rad=still,
        command_openness=np.ones((3, 2)),
        garment_m=np.repeat(home.start_m[None], 3, axis=0),
    )
    made = Attempt(episode=episode, sources=[], failure=None, detail="", placement=np.eye(4), speed_share=0.0)
    monkeypatch.setattr(Bench, "run", lambda self, ticket: made)
    monkeypatch.setattr(Bench, "_judged", lambda self, made: (False, "missed grasp", {}))
    monkeypatch.setattr(sim1.motion.bench, "head_clip", lambda *given, **size: None)
    monkeypatch.setattr(sim1.motion.bench, "write_clip", lambda folder, clip: None)
    (tmp_path / "task.yaml").write_text(TASK)
    bench = Bench(
        garment="towel",
        mesh=SimpleNamespace(faces=None),
        scene=None,
        task=read_task(tmp_path / "task.yaml"),
        pool=[],
        model=a_model(),
        source=Source(home=home, garment_m={}),
        arms=arms,
        cell=SimpleNamespace(config=CellConfig(), physics=FABRIC),
        config=CandidateTrajectoriesConfig(),
    )
    bench.make(Ticket(series="", number=0), tmp_path)
    return read_episode(tmp_path).about


def test_it_says_what_was_to_be_done_in_the_words_of_the_task(record):
    assert record["task_text"] == "turn the towel over"


def test_it_holds_the_physics_that_it_was_simulated_with(record):
    assert physics_of_record(record["physics"], "episode.json") == FABRIC


def test_of_the_demonstrations_garments_only_the_starts_of_interactions_are_kept(tmp_path, home):
    rng, moving = np.random.default_rng(0), np.arange(120)[:, None, None] + home.start_m
    pool = [part for index in range(3) for part in a_demo(f"{index:04d}", rng, 3 * index, success=index < 2)]
    for index in range(3):
        still = Episode(
            time_s=np.arange(120) / RATE_HZ,
            joints_rad=np.repeat(HOME[None], 120, axis=0),
            openness=np.ones((120, 2)),
            command_joints_rad=np.repeat(HOME[None], 120, axis=0),
            command_openness=np.ones((120, 2)),
            garment_m=moving.astype(np.float32),
            about={"cell": asdict(CellConfig())},
        )
        write_episode(tmp_path / "episodes" / f"{index:04d}", still)
    np.savez(tmp_path / "start.npz", garment_m=home.start_m)

    kept = read_source(tmp_path, pool).garment_m
    assert list(kept) == [("0000", 40), ("0001", 40)]
    for garment_m in kept.values():
        np.testing.assert_array_equal(garment_m, moving[40].astype(np.float32))
        assert garment_m.base is None  # a view would hold all frames
