"""A killed run of stage `policy` goes on where it was: what is trained or tried is not made again."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from made_up_cell import CONFIG, failed
from made_up_dataset import toy_trajectories

import sim1.policy.experiment
import sim1.policy.trial_crew
from sim1.policy.model import kept_policy, save_policy
from sim1.policy.stage import check_policy, policy
from sim1.policy.training import TrainingPlan, train


@pytest.fixture
def work(monkeypatch):
    """What is trained, by seed, and tried, in order; `die_at` says before which."""
    done, until = [], {}
    learn, drive = sim1.policy.experiment.train, sim1.policy.trial_crew.run_trial

    def step(name):
        if len(done) == until.get("die_at"):
            raise KeyboardInterrupt
        done.append(name)

    def trained(shown, garments, plan, seed):
        step(f"train {len(shown)} {seed}")
        return learn(shown, garments, plan, seed)

    def tried(bench, trial, *rest):
        step(f"try {trial.name}")
        return drive(bench, trial, *rest)

    monkeypatch.setattr(sim1.policy.experiment, "train", trained)
    monkeypatch.setattr(sim1.policy.trial_crew, "run_trial", tried)
    return done, until


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("die_at", [0, 3, 6, 10])
def test_what_is_trained_and_tried_is_not_made_again_after_a_kill(tmp_path, dataset, bench, artifact, work, die_at):
    """Six networks, then sixteen trials."""
    done, until = work
    inputs, out = {"dataset": {"": dataset.path}}, tmp_path / "p"
    out.mkdir()
    until["die_at"] = die_at
    with pytest.raises(KeyboardInterrupt):
        policy(inputs, out, CONFIG)
    until.clear()
    assert policy(inputs, out, CONFIG) == artifact[1]
    assert len(done) == len(set(done)) == 22
    assert contents(out) == contents(artifact[0])


def test_a_run_that_is_killed_while_it_tidies_up_or_later_needs_no_trial_again(
    tmp_path, dataset, bench, artifact, work, monkeypatch
):
    done, _ = work
    remove = shutil.rmtree

    def die(folder, **options):
        if folder.name == "trials" and folder.exists():
            remove(folder / "episodes")  # half of it is gone
            raise KeyboardInterrupt
        remove(folder, **options)

    inputs, out = {"dataset": {"": dataset.path}}, tmp_path / "p"
    out.mkdir()
    with monkeypatch.context() as patch:
        patch.setattr(shutil, "rmtree", die)
        with pytest.raises(KeyboardInterrupt):
            policy(inputs, out, CONFIG)
    assert (out / "trials").exists()
    for _ in range(2):  # then killed between the stage's end and its artifact's place in the store
        assert policy(inputs, out, CONFIG) == artifact[1]
    assert len(done) == 22
    assert failed(check_policy(out)) == []
    assert contents(out) == contents(artifact[0])
    assert json.loads((out / "facts.json").read_text()) == artifact[1]


def test_a_policy_is_taken_for_what_it_learnt_alone_and_if_it_is_whole(tmp_path):
    plan = TrainingPlan(steps=1, batch=4, learning_rate=1e-3, input_noise=0.0, chunk_frames=5, width=8, depth=1)
    model = train(toy_trajectories()[:1], ["tshirt"], plan, seed=0)
    path = tmp_path / "p.safetensors"
    assert kept_policy(path, "so") is None
    save_policy(path, model, "so")
    assert [file.name for file in tmp_path.iterdir()] == ["p.safetensors"]
    assert kept_policy(path, "so").shape == model.shape
    assert kept_policy(path, "otherwise") is None
    path.write_bytes(path.read_bytes()[:-40])
    assert kept_policy(path, "so") is None


@pytest.mark.parametrize("change", [{"seed": 1}, {"steps": 50}])
def test_policies_of_other_trajectories_or_another_plan_are_trained_anew(tmp_path, dataset, bench, work, change):
    done, _ = work
    inputs, out, config = {"dataset": {"": dataset.path}}, tmp_path / "p", replace(CONFIG, trial_count=0)
    out.mkdir()
    policy(inputs, out, config)
    for again, trained in ((config, 0), (replace(config, **change), 6)):
        (out / "facts.json").unlink()
        done.clear()
        policy(inputs, out, again)
        assert len(done) == trained
