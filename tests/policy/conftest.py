"""What the tests of this room share: a made-up dataset, and an artifact of the stage that was made from it."""

import shutil
from pathlib import Path

import pytest
from made_up_cell import CONFIG, idle_bench
from made_up_dataset import ToyDataset, toy_trajectories, write_dataset

import sim1.policy.trial_crew
from sim1.policy.episodes import Trajectory
from sim1.policy.stage import policy


@pytest.fixture
def trajectories() -> list[Trajectory]:
    return toy_trajectories()


@pytest.fixture
def dataset(tmp_path, trajectories) -> ToyDataset:
    return write_dataset(tmp_path / "dataset", trajectories)


@pytest.fixture(scope="module")
def lasting_dataset(tmp_path_factory) -> ToyDataset:
    """The same for all tests of a file."""
    return write_dataset(tmp_path_factory.mktemp("dataset"), toy_trajectories())


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
