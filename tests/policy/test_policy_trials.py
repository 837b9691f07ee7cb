"""Who drives where, what each trial meets, and how it is judged; the simulated cell is replaced by one that cannot fail."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from made_up_cell import CONFIG, VERTICES, ObedientCell, look, start

import sim1.policy.trial_crew
import sim1.policy.trials
from sim1.cloth.physics import ClothPhysics, Property
from sim1.policy.experiment import trial_garments, trial_models
from sim1.policy.lessons import REAL, Lesson, ModelKey
from sim1.policy.rollout import Driving, Start, StatePilot, observe, roll_out
from sim1.policy.stage import (
    PolicyConfig,
    policy,
)
from sim1.policy.training import TrainingPlan, train
from sim1.policy.trials import BROKEN, Bench, rubbed
from sim1.policy.worlds import SIMULATOR
from sim1.stage import BadInput


def test_placements_are_within_the_limits_of_their_shift_and_the_same_for_every_size(artifact):
    trials = pd.read_parquet(artifact[0] / "evaluation.parquet")
    distance = np.hypot(trials["shift_x_m"], trials["shift_y_m"])
    spatial = trials["shift"] == "spatial"
    assert distance[spatial].max() <= 0.08
    assert distance[~spatial].max() <= 0.01
    assert trials["turn_rad"][spatial].abs().max() <= np.radians(15)
    assert trials["turn_rad"][~spatial].abs().max() == pytest.approx(0.0, abs=1e-12)
    for _, same in trials.groupby(["garment", "shift", "trial"]):
        assert same["shift_x_m"].nunique() == same["turn_rad"].nunique() == 1
    assert trials["turn_rad"][spatial].nunique() == 4


def test_networks_of_one_seed_meet_the_same_placements_and_those_of_another_seed_others(tmp_path, dataset, bench):
    (tmp_path / "p").mkdir()
    config = replace(CONFIG, evaluate_seeds=2, evaluate_garment_count=1)
    policy({"dataset": {"": dataset.path}}, tmp_path / "p", config)
    trials = pd.read_parquet(tmp_path / "p" / "evaluation.parquet")
    assert trials.groupby(["trained_on", "size"])["seed"].nunique().tolist() == [2, 2]
    met = trials.groupby(["shift", "seed", "trial"])["shift_x_m"].unique()
    assert met.map(len).tolist() == [1] * len(met)  # whatever they learnt from: they compare in pairs
    assert met["spatial"].map(min).nunique() == 2 * CONFIG.trial_count  # two seeds: as many placements as trials


def test_friction_is_changed_in_turn_where_that_is_the_shift(tmp_path, dataset, monkeypatch):
    opened = []

    def open_bench(inputs, garment, trials_in, factor):
        opened.append((garment, factor))
        return Bench(world=SIMULATOR, cell=ObedientCell(), start=start(), judge=lambda h: (True, None, {}), look=look)

    monkeypatch.setattr(sim1.policy.trial_crew, "open_bench", open_bench)
    (tmp_path / "p").mkdir()
    config = replace(CONFIG, shifts=("friction",), trial_count=3, evaluate_garment_count=1, evaluate_sizes=1)
    policy({"dataset": {"": dataset.path}}, tmp_path / "p", config)
    trials = pd.read_parquet(tmp_path / "p" / "evaluation.parquet")
    assert trials["friction_factor"].tolist() == [0.6, 1.6, 0.6]
    assert opened == [("towel", 0.6), ("towel", 1.6)]  # a cell is kept


def test_friction_of_all_contacts_is_changed_and_with_it_the_tables_along_either_axis():
    fabric = dict.fromkeys(
        ("area_density_kg_m2", "thickness_m", "stretch_n_m", "poisson", "bending_n_m", "damping_s"), Property(value=0.1)
    )
    uneven = {
        name: {"value": value, "ci95": [0.1, 0.9], "unit": "1"} for name, value in (("mu_x", 0.5), ("mu_y", 0.25))
    }
    wind = {"name": "wind", "parameters": {"c_normal": {"value": 1.3, "ci95": None, "unit": "1"}}}
    known = ClothPhysics(**fabric, effects=({"name": "anisotropic_friction", "parameters": uneven}, wind))
    slippery = rubbed(known, 0.6)
    for contact in ("table", "robot", "self"):
        before, after = (getattr(one.friction, contact).value for one in (known, slippery))
        assert after == pytest.approx(0.6 * before)
    both = slippery.effects[0]["parameters"]
    assert {name: one["value"] for name, one in both.items()} == pytest.approx({"mu_x": 0.3, "mu_y": 0.15})
    assert slippery.effects[1] == wind
    assert rubbed(known, 1.0) == known


def test_a_killed_experiment_goes_on_with_the_trials_that_are_made(tmp_path, dataset, bench, artifact, monkeypatch):
    out, real, made = tmp_path / "p", sim1.policy.trial_crew.run_trial, []
    out.mkdir()

    def run_trial(bench, trial, *rest):
        if len(made) == 5:
            raise KeyboardInterrupt
        made.append(trial.name)
        return real(bench, trial, *rest)

    monkeypatch.setattr(sim1.policy.trial_crew, "run_trial", run_trial)
    with pytest.raises(KeyboardInterrupt):
        policy({"dataset": {"": dataset.path}}, out, CONFIG)
    first, made[:] = list(made), []
    monkeypatch.setattr(
        sim1.policy.trial_crew, "run_trial", lambda b, t, *rest: (made.append(t.name), real(b, t, *rest))[1]
    )
    policy({"dataset": {"": dataset.path}}, out, CONFIG)
    assert len(first) == 5
    assert len(made) == 11
    assert set(first).isdisjoint(made)
    assert (out / "evaluation.parquet").read_bytes() == (artifact[0] / "evaluation.parquet").read_bytes()


def test_a_simulation_that_breaks_is_a_failure_with_its_own_class(tmp_path, dataset, monkeypatch):
    bench = Bench(
        world=SIMULATOR,
        cell=ObedientCell(breaks_at=5),
        start=start(),
        judge=lambda history: (True, None, {}),
        look=look,
    )
    monkeypatch.setattr(sim1.policy.trial_crew, "open_bench", lambda *_: bench)
    (tmp_path / "p").mkdir()
    policy({"dataset": {"": dataset.path}}, tmp_path / "p", CONFIG)
    trials = pd.read_parquet(tmp_path / "p" / "evaluation.parquet")
    assert set(trials["failure"]) == {BROKEN}
    assert not trials["success"].any()
    assert trials["simulated_s"].max() == pytest.approx(5 / 30)


def test_the_judge_sees_the_garment_as_if_it_had_not_been_moved(tmp_path, dataset, monkeypatch):
    seen = []

    def judge(history):
        seen.append(history[0])
        return True, None, {}

    monkeypatch.setattr(
        sim1.policy.trial_crew,
        "open_bench",
        lambda *_: Bench(world=SIMULATOR, cell=ObedientCell(), start=start(), judge=judge, look=look),
    )
    (tmp_path / "p").mkdir()
    policy({"dataset": {"": dataset.path}}, tmp_path / "p", CONFIG)
    assert len(seen) == 16
    for garment in seen:
        np.testing.assert_allclose(garment, start().garment_m, atol=1e-12)


@pytest.mark.parametrize(
    ("count", "first", "driven"),
    [(1, ("towel",), ["towel"]), (1, ("sock",), ["polo"]), (2, ("towel",), ["towel", "polo"]), (0, (), [])],
)
def test_the_preferred_garments_drive_first(count, first, driven):
    assert trial_garments(["polo", "shorts", "towel"], first, count) == driven


@pytest.mark.parametrize(
    ("sizes", "count", "driven"),
    [([2, 4, 8], 2, [2, 8]), ([2, 4, 8], 1, [8]), ([2, 4, 8], 5, [2, 4, 8]), ([3], 2, [3])],
)
def test_the_largest_and_the_smallest_models_drive_first(sizes, count, driven):
    config = PolicyConfig(evaluate_sizes=count, evaluate_seeds=1, seeds=(7, 8))
    lesson = Lesson(kind=REAL, train=[], orders={}, sizes=sizes, held_out=[], splits={})
    assert trial_models(lesson, config) == [ModelKey(REAL, size, 7) for size in driven]


def test_a_garment_without_its_cell_is_named(tmp_path, dataset):
    with pytest.raises(BadInput, match=r"'garment_mesh'.*'towel'"):
        sim1.policy.trials.open_bench({"dataset": {"": dataset.path}}, "towel", "reality")


class FollowingCell(ObedientCell):
    """Its garment moves with the left arm, as in the made-up demonstrations."""

    def __init__(self, reach_rad: float) -> None:
        super().__init__()
        self.reach_rad = reach_rad

    def reset(self, garment_m, joints_rad, openness):
        super().reset(garment_m, joints_rad, openness)
        self.lying_m = garment_m

    def step(self, joints_rad, openness):
        super().step(joints_rad, openness)
        self.garment_m = self.lying_m + 0.1 * self.joints_rad[0, 0] / self.reach_rad


def test_a_policy_drives_the_arms_where_its_demonstration_went(trajectories):
    plan = TrainingPlan(steps=600, batch=40, learning_rate=2e-3, input_noise=0.05, chunk_frames=6, width=64, depth=2)
    demonstration = trajectories[0]
    model = train([demonstration], ["tshirt"], plan, seed=0)
    first, goal = demonstration.state[0].reshape(2, 7), demonstration.action[-1]
    garment = demonstration.keypoints[0].reshape(-1, 3).astype(float)
    begin = Start(garment_m=garment, joints_rad=first[:, :6], openness=first[:, 6])
    cell = FollowingCell(reach_rad=float(goal[0]))
    driving = Driving(rate_hz=10, replan_frames=2, decay=0.5)
    pilot = StatePilot(model, "tshirt", np.arange(VERTICES))
    history = list(roll_out(cell, begin, pilot, driving, duration_s=6.0))
    assert len(history) == 181  # 6 s at the cell's 30 Hz, and the start
    assert np.abs(observe(cell, np.arange(VERTICES))[:14] - goal).max() < 0.1
    jumps = np.abs(np.diff(np.stack(cell.commands), axis=0)).max()
    pace = np.abs(np.diff(demonstration.action, axis=0)).max()  # per policy frame, three cell frames
    assert jumps < pace  # the cell is led through each policy frame, not thrown
