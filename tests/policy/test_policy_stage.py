"""The stages on made-up tables; the simulated cell is replaced by one that cannot fail."""

import hashlib
import json
import shutil
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import sim1.policy.trial_crew
import sim1.policy.trials
from sim1.cloth.cell import SimulationBroke
from sim1.episode import Episode, write_episode
from sim1.policy.experiment import trial_garments, trial_models
from sim1.policy.lessons import GENERATED, REAL, Lesson, ModelKey
from sim1.policy.model import load_policy, save_policy
from sim1.policy.rollout import Driving, Start, observe, roll_out
from sim1.policy.stage import (
    PolicyConfig,
    ScalingReportConfig,
    check_policy,
    check_scaling_report,
    policy,
    scaling_report,
)
from sim1.policy.training import TrainingPlan, train
from sim1.policy.trials import BROKEN, SIMULATOR, Bench
from sim1.progress import listening
from sim1.stage import BadInput

VERTICES = 12
CONFIG = PolicyConfig(
    sizes=(2, 4, 99),
    seeds=(0, 1),
    steps=60,
    batch=32,
    width=32,
    depth=2,
    chunk_s=0.5,
    replan_s=0.2,
    trial_count=2,
    evaluate_garment_count=2,
    shifts=("in-domain", "spatial"),
    processes=1,
)


@dataclass
class ObedientCell:
    """Arms are where they are told to be, the garment stays; it may break at a frame."""

    breaks_at: int | None = None
    frame: int = 0
    commands: list = field(default_factory=list)

    def reset(self, garment_m, joints_rad, openness):
        self.garment_m, self.joints_rad, self.openness, self.frame = garment_m, joints_rad, openness, 0

    def step(self, joints_rad, openness):
        self.joints_rad, self.openness = np.array(joints_rad), np.array(openness)
        self.commands.append(np.concatenate([joints_rad, openness[:, None]], axis=1).ravel())
        self.frame += 1
        if self.frame == self.breaks_at:
            raise SimulationBroke(self.frame, 0, "vertex 0 is lost")


def start() -> Start:
    garment = np.random.default_rng(0).uniform(-0.1, 0.1, (VERTICES, 3))
    return Start(garment_m=garment, joints_rad=np.zeros((2, 6)), openness=np.ones(2))


def look(garment_m):
    assert garment_m.shape == (VERTICES, 3)
    return np.zeros((12, 16, 3), np.uint8)


def idle_bench() -> Bench:
    """A garment that nobody ever folds."""

    def judge(history):
        return False, "not_folded", {"frames": len(history)}

    return Bench(world=SIMULATOR, cell=ObedientCell(), start=start(), judge=judge, look=look)


@pytest.fixture
def bench(monkeypatch):
    bench = idle_bench()
    monkeypatch.setattr(sim1.policy.trial_crew, "open_bench", lambda *_: bench)


@pytest.fixture(scope="module")
def made(tmp_path_factory, lasting_dataset):
    """An artifact of the stage and its facts."""
    out = tmp_path_factory.mktemp("policy")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sim1.policy.trial_crew, "open_bench", lambda *_: idle_bench())
        return out, policy({"dataset": {"": lasting_dataset.path}}, out, CONFIG)


@pytest.fixture
def artifact(tmp_path, made):
    """A copy of it, to be damaged."""
    return Path(shutil.copytree(made[0], tmp_path / "policy")), made[1]


def failed(findings):
    return [finding.name for finding in findings if not finding.passed and finding.blocking]


def test_every_model_and_every_trial_is_there(artifact):
    out, facts = artifact
    assert failed(check_policy(out)) == []
    about = json.loads((out / "policy.json").read_text())
    assert about["lessons"][GENERATED]["sizes"] == [2, 4, 6]  # 10 trajectories, 2 of each garment held out
    assert facts["model_count"] == 6
    trials = pd.read_parquet(out / "evaluation.parquet")
    assert len(trials) == 2 * 2 * 2 * 2  # garments, shifts, sizes, trials; one seed drives
    assert not (out / "trials").exists()
    assert set(trials["size"]) == {2, 6}
    assert not trials["success"].any()
    assert set(trials["failure"]) == {"not_folded"}


def test_placements_are_within_the_limits_of_their_shift_and_the_same_for_every_model(artifact):
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


def write_demonstrations(folder, trajectories):
    """Real demonstrations in the cell's format: the towel's made-up trajectories at 30 Hz, and one that failed."""
    for number, item in enumerate(trajectories):
        often = [np.repeat(array, 3, axis=0) for array in (item.state, item.action, item.keypoints)]
        state, action = (array.reshape(-1, 2, 7) for array in often[:2])
        episode = Episode(
            time_s=np.arange(len(state)) / 30,
            joints_rad=state[..., :6],
            openness=state[..., 6],
            command_joints_rad=action[..., :6],
            command_openness=action[..., 6],
            garment_m=often[2].reshape(len(state), -1, 3),
            about={"success": number > 0, "sources": []},
        )
        write_episode(folder / "episodes" / f"{number:04d}", episode)
    return folder


def test_real_demonstrations_teach_beside_the_generated_ones_and_test_both(tmp_path, dataset, bench, trajectories):
    towels = [item for item in trajectories if item.garment == "towel"]
    demos = {"towel": write_demonstrations(tmp_path / "demos", towels), "tshirt": tmp_path / "none"}
    (tmp_path / "none").mkdir()
    (tmp_path / "none" / "none.json").write_text('{"why": "nobody asked"}')
    out = tmp_path / "p"
    out.mkdir()
    policy({"dataset": {"": dataset.path}, "real_demos": demos}, out, replace(CONFIG, real_sizes=(1, 2)))
    assert failed(check_policy(out)) == []
    about = json.loads((out / "policy.json").read_text())
    assert about["lessons"][REAL]["sizes"] == [1, 2]  # four that succeeded, one kept to test
    tested = pd.read_parquet(out / "open_loop.parquet")
    pairs = set(tested[["trained_on", "tested_on"]].itertuples(index=False, name=None))
    assert pairs == {(GENERATED, GENERATED), (GENERATED, REAL), (REAL, REAL)}
    real = tested[tested["tested_on"] == REAL]
    held = set(real["trajectory"])
    assert held.isdisjoint(name.split("/")[1] for name in about["lessons"][REAL]["training_sets"]["2"])
    assert held.isdisjoint({"0000"})  # it failed
    trials = pd.read_parquet(out / "evaluation.parquet")
    assert set(trials["trained_on"]) == {GENERATED, REAL}


def test_without_real_demonstrations_it_is_said_why(tmp_path, dataset, bench):
    (tmp_path / "none").mkdir()
    (tmp_path / "none" / "none.json").write_text('{"why": "nobody asked"}')
    (tmp_path / "p").mkdir()
    policy({"dataset": {"": dataset.path}, "real_demos": {"towel": tmp_path / "none"}}, tmp_path / "p", CONFIG)
    assert json.loads((tmp_path / "p" / "policy.json").read_text())["no_real_demonstrations"] == "nobody asked"
    (tmp_path / "s").mkdir()
    scaling_report({"policy": {"": tmp_path / "p"}}, tmp_path / "s", ScalingReportConfig())
    assert "nobody asked" in (tmp_path / "s" / "report.html").read_text()


def test_held_out_trajectories_never_train(artifact, dataset):
    about = json.loads((artifact[0] / "policy.json").read_text())
    tested = pd.read_parquet(artifact[0] / "open_loop.parquet")
    lesson = about["lessons"][GENERATED]
    trained = set(lesson["training_sets"][str(max(lesson["sizes"]))])
    assert trained.isdisjoint({f"{row.garment}/{row.trajectory}" for row in tested.itertuples()})
    assert {row["split"] for row in lesson["splits"]} == {"source"}


def test_same_config_same_bytes(tmp_path, dataset, bench, artifact):
    again = tmp_path / "again"
    again.mkdir()
    policy({"dataset": {"": dataset.path}}, again, CONFIG)
    for path in sorted(artifact[0].rglob("*")):
        if path.is_file():
            twin = again / path.relative_to(artifact[0])
            assert hashlib.sha256(path.read_bytes()).digest() == hashlib.sha256(twin.read_bytes()).digest(), path.name


def test_progress_rises_from_nothing_to_all(tmp_path, dataset, bench):
    seen = []
    (tmp_path / "p").mkdir()
    with listening(lambda done, total, what: seen.append(done / total)):
        policy({"dataset": {"": dataset.path}}, tmp_path / "p", CONFIG)
    assert seen == sorted(seen)
    assert (seen[0], seen[-1]) == (0.0, 1.0)


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


def test_checks_see_a_lost_trial_a_lost_model_and_weights_that_are_no_numbers(artifact):
    out, _ = artifact
    trials = pd.read_parquet(out / "evaluation.parquet")
    trials.iloc[1:].to_parquet(out / "evaluation.parquet")
    assert failed(check_policy(out)) == ["every_trial_accounted_for"]
    trials.to_parquet(out / "evaluation.parquet")
    model = load_policy(out / "policies" / "generated_2_0.safetensors")
    model.body[0].weight.data[0, 0] = float("nan")
    save_policy(out / "policies" / "generated_2_0.safetensors", model)
    assert failed(check_policy(out)) == ["weights_finite"]
    (out / "policies" / "generated_2_0.safetensors").unlink()
    assert "every_model_saved" in failed(check_policy(out))


@pytest.mark.parametrize(
    ("count", "first", "driven"),
    [(1, ("towel",), ["towel"]), (1, ("sock",), ["polo"]), (2, ("towel",), ["towel", "polo"]), (0, (), [])],
)
def test_the_preferred_garments_drive_first(count, first, driven):
    config = PolicyConfig(evaluate_garment_count=count, evaluate_first=first)
    assert trial_garments(["polo", "shorts", "towel"], config) == driven


@pytest.mark.parametrize(
    ("sizes", "count", "driven"),
    [([2, 4, 8], 2, [2, 8]), ([2, 4, 8], 1, [8]), ([2, 4, 8], 5, [2, 4, 8]), ([3], 2, [3])],
)
def test_the_largest_and_the_smallest_models_drive_first(sizes, count, driven):
    config = PolicyConfig(evaluate_sizes=count, evaluate_seeds=1, seeds=(7, 8))
    lesson = Lesson(kind=REAL, order=[], sizes=sizes, held_out=[], splits={})
    assert trial_models(lesson, config) == [ModelKey(REAL, size, 7) for size in driven]


def test_a_dataset_of_nothing_to_train_on_is_refused(tmp_path, dataset):
    with pytest.raises(BadInput, match="no trajectory to train on"):
        policy({"dataset": {"": dataset.path}}, tmp_path, PolicyConfig(sizes=(0,)))


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
    history = roll_out(cell, begin, model, "tshirt", np.arange(VERTICES), driving, duration_s=6.0)
    assert len(history) == 181  # 6 s at the cell's 30 Hz, and the start
    assert np.abs(observe(cell, np.arange(VERTICES))[:14] - goal).max() < 0.1
    jumps = np.abs(np.diff(np.stack(cell.commands), axis=0)).max()
    pace = np.abs(np.diff(demonstration.action, axis=0)).max()  # per policy frame, three cell frames
    assert jumps < pace  # the cell is led through each policy frame, not thrown


def test_scaling_report_states_its_counts_and_stands_alone(tmp_path, artifact):
    out = tmp_path / "scaling"
    out.mkdir()
    facts = scaling_report({"policy": {"": artifact[0]}}, out, ScalingReportConfig())
    assert failed(check_scaling_report(out)) == []
    assert facts["trial_count"] == 16
    page = (out / "report.html").read_text()
    assert "0 of 4 = 0 % (95 % interval 0 to 49 %)" in page
    assert "scripted expert" in page
    assert "Not known" in page
    page = page.replace("0 of 4", "4 of 4")
    (out / "report.html").write_text(page + '<img src="https://example.org/x.png">')
    assert failed(check_scaling_report(out)) == ["page_states_its_counts", "page_stands_alone"]
