"""The stage on painted pictures: what it leaves behind, that it goes on after a kill, and what its check sees."""

import hashlib
import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from painted_stage import CONFIG, Killed, contents, failed, painted_stage
from painted_world import HELD_OUT, MITE, SOURCES
from safetensors.torch import load_file, save_file

from sim1.policy.image.clips import split_clips
from sim1.policy.image.measures import BLANK, DATASET
from sim1.policy.image.policy_file import SCHEMA
from sim1.policy.image.shifts import TITLES
from sim1.policy.image.stage import check_image_policy
from sim1.progress import listening
from sim1.stage import BadInput

pytestmark = pytest.mark.filterwarnings("ignore")  # of torch and torchvision, not of this project


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    with painted_stage(tmp_path_factory.mktemp("world")) as world:
        yield world


@pytest.fixture(scope="module")
def made(world, tmp_path_factory):
    out, seen = tmp_path_factory.mktemp("made") / "out", []
    with listening(lambda done, total, what: seen.append(done / total)):
        facts = world.make(out)
    return out, facts, seen


@pytest.fixture
def artifact(made, tmp_path) -> Path:
    """A copy to be damaged."""
    return Path(shutil.copytree(made[0], tmp_path / "artifact"))


def test_every_held_out_clip_and_every_look_is_measured(made):
    out, facts, _ = made
    assert failed(check_image_policy(out)) == []
    about = json.loads((out / "image_policy.json").read_text())
    assert about["elevation_offset_deg"] == {"viewpoint_down": -10.0, "viewpoint_up": 10.0}
    assert (facts["training_trajectory_count"], facts["held_out_trajectory_count"]) == (4, 1)
    errors = pd.read_parquet(out / "open_loop.parquet")
    assert set(errors["trajectory"]) == {HELD_OUT}
    assert set(errors["source"]) == {SOURCES[HELD_OUT]}
    assert errors["pictures"].value_counts().to_dict() == {DATASET: 2, BLANK: 1, **dict.fromkeys(TITLES, 1)}
    assert errors["hold_joint_error_rad"].nunique() == 1  # the motion is the same in all of them
    looks = errors[errors["pictures"].isin([*TITLES, BLANK])]
    assert looks["joint_error_rad"].nunique() == len(looks)  # and the pictures differ
    assert {path.name for path in out.iterdir()} == {
        "policies", "views", "image_policy.json", "open_loop.parquet", "training.parquet", "report.html",
        "errors.png", "looks.png", "loss.png",
    }  # fmt: skip


def test_the_network_of_a_seed_is_the_same_whichever_others_there_are(world, made, tmp_path):
    world.make(tmp_path / "out", replace(CONFIG, seeds=(7, 0), processes=1, shifted_trajectories=0))
    assert contents(tmp_path / "out" / "policies" / "0") == contents(made[0] / "policies" / "0")


def test_the_checkpoint_carries_the_normalisation_of_the_training_part(made, world):
    parts = split_clips(world.inputs["dataset"][""], CONFIG.test_share, CONFIG.seed)
    (kept,) = (made[0] / "policies" / "0").glob("policy_preprocessor_*normalizer*.safetensors")
    statistics = load_file(kept)
    assert not any("keypoints" in name for name in statistics)
    for name, column in (("observation.state", "state"), ("action", "action")):
        values = np.concatenate([getattr(clip.trajectory, column) for clip in parts.train])
        np.testing.assert_allclose(statistics[f"{name}.mean"], values.mean(axis=0), atol=1e-6)


def test_the_page_says_what_stands_in_for_reality_and_that_nothing_drove(made):
    page = (made[0] / "report.html").read_text()
    for words in ("scripted expert", "no robot was used", "Nothing here is a success rate", "A very small ACT"):
        assert words in page
    assert all("nan" not in part.partition('"')[2] for part in f'"{page}'.split("base64,"))  # a picture may spell it


def test_no_path_of_this_machine_is_in_the_artifact(made, world):
    folder = str(world.inputs["dataset"][""].parent).encode()
    for path in made[0].rglob("*"):
        assert path.is_dir() or folder not in path.read_bytes(), path


def test_progress_rises_from_nothing_to_all(made):
    seen = made[2]
    assert seen == sorted(seen)
    assert (seen[0], seen[-1]) == (0.0, 1.0)


@pytest.mark.parametrize("words", ["episodes", "step 3 of 4", "frames of held-out trajectories"])
def test_a_run_that_was_killed_anywhere_ends_with_the_same_bytes(world, made, tmp_path, words):
    def sink(done, total, what):
        if words in what:
            raise Killed

    with listening(sink), pytest.raises(Killed):
        world.make(tmp_path / "out")
    before = world.painter.painted
    (tmp_path / "out" / "frames").mkdir(exist_ok=True)  # killed before it was cleared away
    world.make(tmp_path / "out")
    assert world.painter.painted == before  # no picture is rendered twice
    assert contents(tmp_path / "out") == contents(made[0])


def test_networks_that_were_trained_on_a_gpu_are_said_to_be_wherever_the_run_ends(world, made, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(made[0], out)
    config = out / "policies" / "0" / "config.json"
    config.write_text(json.dumps(json.loads(config.read_text()) | {"device": "cuda"}))
    facts = world.make(out)  # killed on a machine with a GPU after the training, gone on with here
    assert json.loads((out / "image_policy.json").read_text())["device"] == "cuda"
    assert facts["policy"].endswith("on cuda")


def test_a_training_that_began_from_published_weights_does_not_go_on_from_others(world, made, tmp_path):
    published, folder = tmp_path / "published", tmp_path / "policies"
    shutil.copytree(made[0] / "policies" / "0", published)
    folder.mkdir()
    needs = {"weights": {"folder": "../published", "source": "someone/mite"}}
    text = {"schema": SCHEMA, "title": "Goes on", "type": "act", "settings": MITE, "needs": needs}
    (folder / "mite.yaml").write_text(yaml.safe_dump(text))

    def sink(done, total, what):
        if "step 3 of 4" in what:
            raise Killed

    def make():
        return world.make(tmp_path / "out", policies={"": folder})

    with listening(sink), pytest.raises(Killed):
        make()
    path = published / "model.safetensors"
    kept, weights = path.read_bytes(), load_file(path)
    weights["model.action_head.bias"] += 1
    save_file(weights, path, metadata={"format": "pt"})
    with pytest.raises(
        BadInput, match=r"published/model\.safetensors: is not what the interrupted training began from"
    ):
        make()
    path.write_bytes(kept)
    make()
    digest = json.loads((tmp_path / "out" / "image_policy.json").read_text())["weights_sha256"]
    assert digest == hashlib.sha256(kept).hexdigest()
    before = contents(tmp_path / "out")
    make()  # killed when all was done but its place in the store
    assert contents(tmp_path / "out") == before


def test_the_check_sees_weights_that_are_no_numbers(artifact):
    weights = load_file(artifact / "policies" / "0" / "model.safetensors")
    weights["model.action_head.bias"][0] = float("nan")
    save_file(weights, artifact / "policies" / "0" / "model.safetensors", metadata={"format": "pt"})
    assert failed(check_image_policy(artifact)) == ["weights_finite"]


def test_the_check_sees_a_policy_that_lerobot_cannot_load(artifact):
    (artifact / "policies" / "0" / "policy_preprocessor.json").unlink()
    assert failed(check_image_policy(artifact)) == ["lerobot_loads_it_again"]


def test_the_check_sees_a_lost_error_a_stranger_and_a_lost_step(artifact):
    errors = pd.read_parquet(artifact / "open_loop.parquet")
    errors.iloc[1:].to_parquet(artifact / "open_loop.parquet")
    assert failed(check_image_policy(artifact)) == ["every_error_measured"]
    errors.assign(trajectory="0000").to_parquet(artifact / "open_loop.parquet")
    assert failed(check_image_policy(artifact)) == ["held_out_alone_is_tested"]
    errors.to_parquet(artifact / "open_loop.parquet")
    pd.read_parquet(artifact / "training.parquet").iloc[1:].to_parquet(artifact / "training.parquet")
    assert failed(check_image_policy(artifact)) == ["every_step_has_a_loss"]


def test_figures_in_the_record_are_those_of_the_table(made):
    out, facts, _ = made
    errors = pd.read_parquet(out / "open_loop.parquet")
    about = json.loads((out / "image_policy.json").read_text())
    for point, row in zip(about["points"], facts["shifts"], strict=True):
        mean = errors.loc[errors["pictures"] == point["pictures"], "joint_error_rad"].mean()
        assert point["joint_rad"]["value"] == pytest.approx(mean) == row["joint_error_rad"]
