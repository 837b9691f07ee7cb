"""The stage on painted pictures with other settings and inputs: several networks, fewer pictures, nothing held out, what cannot be trained."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from painted_stage import CONFIG, Killed, contents, failed, painted_stage
from painted_world import write_world

from sim1.policy.image.measures import DATASET
from sim1.policy.image.shifts import TITLES
from sim1.policy.image.stage import check_image_policy
from sim1.policy.image.training import train
from sim1.progress import listening
from sim1.stage import BadInput

pytestmark = pytest.mark.filterwarnings("ignore")  # of torch and torchvision, not of this project


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    with painted_stage(tmp_path_factory.mktemp("world")) as world:
        yield world


def test_networks_of_several_seeds_differ_and_are_the_same_whoever_makes_them(world, tmp_path):
    """Each in a process of its own, of which progress is told; then one after the other, killed within the second."""
    config, seen = replace(CONFIG, seeds=(0, 7), processes=2, steps=12), []
    with listening(lambda done, total, what: seen.append((what, done / total))):
        facts = world.make(tmp_path / "two", config)
    assert facts["network_count"] == 2
    assert any(0.3 < share < 0.5 for what, share in seen if what == "0 of 2 networks")
    assert failed(check_image_policy(tmp_path / "two")) == []

    def sink(done, total, what):
        if "step 9 of 12" in what and done / total > 0.5:
            raise Killed

    with listening(sink), pytest.raises(Killed):
        world.make(tmp_path / "one", replace(config, processes=1))
    world.make(tmp_path / "one", replace(config, processes=1))
    assert contents(tmp_path / "one") == contents(tmp_path / "two")

    about = json.loads((tmp_path / "two" / "image_policy.json").read_text())
    errors = pd.read_parquet(tmp_path / "two" / "open_loop.parquet")
    assert errors.groupby("seed").size().to_dict() == {0: 8, 7: 8}
    plain = errors[errors["pictures"] == DATASET].groupby("seed")["joint_error_rad"].mean()
    assert {network["seed"]: network["joint_error_rad"] for network in about["networks"]} == pytest.approx(dict(plain))
    assert plain[0] != plain[7]
    assert about["points"][0]["joint_rad"]["value"] == pytest.approx(plain.mean())
    assert about["points"][0]["clip_count"] == 2

    shutil.copytree(tmp_path / "one" / "policies" / "0", tmp_path / "one" / "policies" / "7", dirs_exist_ok=True)
    assert failed(check_image_policy(tmp_path / "one")) == ["networks_differ"]


def test_a_network_that_diverged_is_told(world, tmp_path, monkeypatch):
    def diverged(*args):
        trained, losses = train(*args)
        next(iter(trained.policy.parameters())).data[:] = np.nan
        return trained, losses

    monkeypatch.setattr("sim1.policy.image.networks.train", diverged)
    with pytest.raises(BadInput, match=r"seed 0 are not finite after 4 steps; set a smaller learning rate"):
        world.make(tmp_path / "out")


def test_where_nothing_is_held_out_a_policy_is_trained_and_the_page_says_so(world, tmp_path_factory, tmp_path):
    alone = write_world(tmp_path_factory.mktemp("alone"), sources={"0000": "0000"}, frame_count=13)
    facts = world.make(tmp_path / "out", **{name: alone[name] for name in ("dataset", "rendered_episodes")})
    assert facts["held_out_trajectory_count"] == 0
    assert facts["held_out_joint_error_rad"] is None
    assert failed(check_image_policy(tmp_path / "out")) == []
    assert "nothing was measured" in (tmp_path / "out" / "report.html").read_text()


def test_without_changed_pictures_the_dataset_alone_is_tested(world, tmp_path):
    facts = world.make(tmp_path / "out", replace(CONFIG, shifted_trajectories=0, evaluate_every=4))
    assert [row["pictures"] for row in facts["shifts"]] == [DATASET]
    assert failed(check_image_policy(tmp_path / "out")) == []
    assert pd.read_parquet(tmp_path / "out" / "open_loop.parquet")["frame_count"].tolist() == [3, 3]  # of 9


@pytest.mark.parametrize(("every", "rendered"), [(1, 9), (5, 2), (4, 5), (3, 9)])
def test_only_frames_that_are_tried_are_rendered_and_tried_on_the_same_motion(world, tmp_path, every, rendered):
    before = world.painter.painted
    world.make(tmp_path / "out", replace(CONFIG, evaluate_every=every, steps=1))
    assert world.painter.painted - before == rendered * len(
        TITLES
    )  # 9 frames at 10 Hz, every gcd(every, 10)-th of them
    errors = pd.read_parquet(tmp_path / "out" / "open_loop.parquet")
    assert set(errors["frame_count"]) == {len(range(0, 9, every))}
    assert errors["hold_joint_error_rad"].nunique() == 1
    assert failed(check_image_policy(tmp_path / "out")) == []


def test_a_policy_that_cannot_be_trained_here_fails_before_anything_is_rendered(world, tmp_path):
    before = world.painter.painted
    with pytest.raises(BadInput, match=r"no policy 'act'; there are mite"):
        world.make(tmp_path / "out", replace(CONFIG, policy="act"))
    assert world.painter.painted == before


def test_a_damaged_dataset_is_named(world, tmp_path):
    broken = shutil.copytree(world.inputs["dataset"][""], tmp_path / "dataset")
    (broken / "lerobot" / "meta" / "info.json").unlink()
    with pytest.raises(BadInput, match=r"info\.json"):
        world.make(tmp_path / "out", dataset={"": broken})
