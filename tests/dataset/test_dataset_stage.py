"""Rendered episodes become a dataset that LeRobot loads, with the values that went in."""

import hashlib
import json
import os
import socket
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from rendered_towel import ROBOT, TASK, frame_image, make_episode, write_rendered

from sim1.cloth.physics import nominal_from_priors, write_physics
from sim1.data_file import read_data_file
from sim1.dataset.keypoints import KEYPOINTS, keypoint_indices
from sim1.dataset.stage import DatasetConfig, DatasetFile, check_dataset, check_source_owner, dataset
from sim1.stage import BadInput

CONFIG = DatasetConfig(keypoint_count=5)
DATA = Path(__file__).parents[2] / "data"


def digests(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def modelled(folder: Path) -> dict[str, dict[str, Path]]:
    """What the pipeline knows of the towel's physics; of the shorts it knows nothing."""
    (folder / "physics").mkdir(exist_ok=True)
    fabric = yaml.safe_load((DATA / "garments/towel.yaml").read_text())["fabric"]
    drag = {"name": "air_drag", "parameters": {"c_normal": {"value": 1.2, "ci95": None, "unit": "1"}}}
    sticky = {"name": "adhesion", "parameters": {"pressure": {"value": 1.0, "ci95": None, "unit": "Pa"}}}
    write_physics(folder / "physics/model.yaml", replace(nominal_from_priors(fabric), effects=(drag, sticky)))
    write_physics(folder / "physics/cell.yaml", replace(nominal_from_priors(fabric), effects=(drag,)))
    (folder / "physics/verdict.json").write_text(json.dumps({"schema": "sim1.verdict/1", "verdict": "named"}))
    made = {name: {"towel": folder / "physics"} for name in ("calibrated_physics", "mismatch_report")}
    return {"robot": ROBOT} | made


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("dataset")
    inputs = {
        "rendered_episodes": {
            name: write_rendered(folder / name, variants=count) for name, count in (("towel", 2), ("shorts", 1))
        }
    } | modelled(folder)
    out = folder / "out"
    out.mkdir()
    facts = dataset(inputs, out, CONFIG)
    assert (facts["episodes"], facts["frames"]) == (6, 3 * (7 + 9))
    return out


@pytest.fixture
def offline(monkeypatch):
    def refuse(*args, **kwargs):
        raise AssertionError("a network connection was tried")

    monkeypatch.setattr(socket.socket, "connect", refuse)
    monkeypatch.setattr(socket, "getaddrinfo", refuse)


def test_lerobot_loads_and_iterates_the_dataset_without_a_network(made, offline):
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    loaded = LeRobotDataset("sim1/folding", root=made / "lerobot", video_backend="pyav")
    assert (loaded.num_episodes, loaded.num_frames, loaded.fps) == (6, 48, 10)
    keypoints = keypoint_indices(np.random.default_rng(9).normal(size=(40, 3)), 5)
    # Garments in order of name: episodes 0 and 1 are shorts, 2 to 5 towels, each trajectory in two appearances.
    row = 0
    shown = [(0, 7, 0), (1, 9, 0), (0, 7, 0), (0, 7, 1), (1, 9, 0), (1, 9, 1)]
    for index, (number, count, variant) in enumerate(shown):
        source = make_episode(19 if number == 0 else 25, seed=number)
        for frame in range(count):
            item = loaded[row]
            assert int(item["episode_index"]) == index
            assert item["task"] == TASK
            assert float(item["timestamp"]) == pytest.approx(frame / 10)
            np.testing.assert_array_equal(item["observation.state"].numpy(), source.state()[3 * frame])
            before_next = min(3 * frame + 2, source.frame_count - 1)
            np.testing.assert_array_equal(item["action"].numpy(), source.action()[before_next])
            np.testing.assert_array_equal(item[KEYPOINTS].numpy(), source.garment_m[3 * frame][keypoints].ravel())
            picture = 255 * item["observation.images.head"].permute(1, 2, 0).numpy()
            assert np.abs(picture - frame_image(frame, hue=60 + 100 * variant + 50 * number)).mean() < 6.0
            row += 1


def test_lerobot_hands_no_policy_what_only_a_simulator_knows(made):
    from lerobot.configs import FeatureType
    from lerobot.utils.feature_utils import dataset_to_policy_features

    features = json.loads((made / "lerobot/meta/info.json").read_text())["features"]
    assert KEYPOINTS in features
    taken = dataset_to_policy_features(features)
    assert {name: one.type for name, one in taken.items()} == {
        "observation.state": FeatureType.STATE,
        "observation.images.head": FeatureType.VISUAL,
        "action": FeatureType.ACTION,
    }
    assert f"`{KEYPOINTS}` is privileged" in (made / "README.md").read_text()


def test_its_own_check_passes(made):
    findings = check_dataset(made)
    assert all(finding.passed for finding in findings), findings
    assert len(findings) == 13


def test_provenance_tells_trajectory_appearance_and_sources(made):
    rows = pd.read_parquet(made / "provenance.parquet")
    assert rows["trajectory"].tolist() == ["0000", "0001", "0000", "0000", "0001", "0001"]
    assert rows["appearance"].tolist() == [0, 0, 0, 1, 0, 1]
    assert [list(sources) for sources in rows["sources"][:2]] == [["0000"], ["0001"]]


def test_provenance_says_what_is_known_of_the_simulated_cloth(made):
    shorts, *_, towel = pd.read_parquet(made / "provenance.parquet")["physics"].map(json.loads)
    assert shorts is None
    assert towel["values"]["area_density_kg_m2"] == 0.30
    assert towel["friction"].keys() == {"table", "robot", "self"}
    assert towel["effects"] == ["air_drag"]
    assert towel["effects_not_simulated"] == ["adhesion"]
    assert towel["verdict"] == "named"
    model = (made.parent / "physics/cell.yaml").read_bytes()
    assert towel["model_sha256"] == hashlib.sha256(model).hexdigest()


def test_a_damaged_verdict_is_named(tmp_path):
    inputs = {"rendered_episodes": {"towel": write_rendered(tmp_path / "towel")}} | modelled(tmp_path)
    (tmp_path / "physics/verdict.json").write_text("{")
    with pytest.raises(BadInput, match=r"verdict\.json: not a readable verdict"):
        dataset(inputs, tmp_path / "out", CONFIG)


def test_the_licence_is_a_line_of_data_and_the_card_says_where(made, tmp_path):
    assert "License: unknown (whoever owns the data names it in `data/dataset.yaml`" in (made / "README.md").read_text()
    owner = tmp_path / "dataset.yaml"
    owner.write_text("schema: sim1.dataset/1\nlicense: cc-by-4.0\n")
    check_source_owner(owner)
    artifacts = {"towel": write_rendered(tmp_path / "towel", frame_counts=(19,))}
    (tmp_path / "out").mkdir()
    dataset({"robot": ROBOT, "rendered_episodes": artifacts, "owner": {"": owner}}, tmp_path / "out", CONFIG)
    card = (tmp_path / "out" / "README.md").read_text()
    assert card.startswith("---\nlicense: cc-by-4.0\n")
    assert "License: cc-by-4.0.\n" in card
    owner.write_text("schema: sim1.dataset/1\nlicence: cc-by-4.0\n")
    with pytest.raises(BadInput, match=r"dataset\.yaml: unknown key 'licence'"):
        check_source_owner(owner)
    assert DatasetFile() == read_data_file(DATA / "dataset.yaml", DatasetFile, "sim1.dataset/1")


def test_the_same_input_gives_the_same_bytes_without_a_word_on_the_terminal(made, tmp_path, capfd):
    inputs = {"rendered_episodes": {name: made.parent / name for name in ("towel", "shorts")}}
    dataset(inputs | modelled(made.parent), tmp_path, CONFIG)
    assert digests(tmp_path) == digests(made)
    assert capfd.readouterr() == ("", "")
    stats = json.loads((made / "lerobot/meta/stats.json").read_text())
    assert list(stats) == sorted(stats)


@pytest.mark.slow
def test_another_process_with_other_hashes_gives_the_same_bytes(made, tmp_path):
    code = (
        "import sys; from pathlib import Path; from sim1.dataset.stage import DatasetConfig, dataset\n"
        "folder = Path(sys.argv[1])\n"
        "inputs = {'rendered_episodes': {name: folder / name for name in ('towel', 'shorts')}}\n"
        "inputs |= {name: {'towel': folder / 'physics'} for name in ('calibrated_physics', 'mismatch_report')}\n"
        "inputs |= {'robot': {'': Path(sys.argv[3])}}\n"
        "dataset(inputs, Path(sys.argv[2]), DatasetConfig(keypoint_count=5))"
    )
    environment = {**os.environ, "PYTHONHASHSEED": "7", "PYTHONPATH": str(Path(__file__).parents[2])}
    subprocess.run(
        [sys.executable, "-c", code, str(made.parent), str(tmp_path), str(ROBOT[""])], check=True, env=environment
    )
    assert digests(tmp_path) == digests(made)


def test_nothing_in_the_dataset_names_the_machine(made):
    for path in made.rglob("*"):
        if path.is_file():
            assert str(made.parent).encode() not in path.read_bytes(), path


def test_the_card_states_counts_license_and_what_is_simulated(made):
    card = (made / "README.md").read_text()
    for words in (
        "license: unknown",
        "6 episodes, 48 frames at 10 Hz",
        "scripted expert",
        "| towel | turn the towel over | 2 | 2.0 | 4 | 32 |",
        "The 6 episodes show\n  1 of them, with 1 tables and 1 rooms and their light;\n",
        "the head camera's elevation is the same in all of them, +0.0° from where the scene has it.",
        "0 of 6 episodes show the garment's scanned texture,\n  the others 1 made-up fabrics",
    ):
        assert words in card
    for name in ("frames.png", "motion.png"):
        assert f"({name})" in card
        assert (made / name).stat().st_size < 200_000


def test_nothing_rendered_is_refused(tmp_path):
    with pytest.raises(BadInput, match="no rendered episodes"):
        dataset({}, tmp_path, CONFIG)
    write_rendered(tmp_path / "towel", frame_counts=())
    with pytest.raises(BadInput, match="no trajectory was accepted"):
        dataset({"robot": ROBOT, "rendered_episodes": {"towel": tmp_path / "towel"}}, tmp_path / "out", CONFIG)


def test_garments_rendered_at_different_rates_are_refused(tmp_path):
    artifacts = {"towel": write_rendered(tmp_path / "towel"), "shorts": write_rendered(tmp_path / "shorts", rate_hz=15)}
    with pytest.raises(BadInput, match=r"rate_hz differ between garments: \[10, 15\]"):
        dataset({"robot": ROBOT, "rendered_episodes": artifacts}, tmp_path / "out", CONFIG)


def test_an_episode_that_does_not_say_what_was_to_be_done_is_named(tmp_path):
    artifact = write_rendered(tmp_path / "towel")
    path = artifact / "episodes/0001/episode.json"
    path.write_text(
        json.dumps({key: value for key, value in json.loads(path.read_text()).items() if key != "task_text"})
    )
    with pytest.raises(BadInput, match=r"0001/episode\.json: task_text is None.*make the episode again"):
        dataset({"robot": ROBOT, "rendered_episodes": {"towel": artifact}}, tmp_path / "out", CONFIG)


def test_a_missing_frame_is_refused_by_name(tmp_path):
    artifact = write_rendered(tmp_path / "towel")
    (artifact / "episodes/0001/v0/head/000004.png").unlink()
    with pytest.raises(BadInput, match=r"0001/v0: frames per camera \{'head': 8\}"):
        dataset({"robot": ROBOT, "rendered_episodes": {"towel": artifact}}, tmp_path / "out", CONFIG)


def test_frames_whose_appearance_is_told_in_another_schema_are_refused(tmp_path):
    artifact = write_rendered(tmp_path / "towel")
    path = artifact / "episodes/0001/v0/appearance.json"
    path.write_text(path.read_text().replace("sim1.appearance/3", "sim1.appearance/1"))
    with pytest.raises(
        BadInput, match=r"0001/v0/appearance\.json: .*schema is 'sim1.appearance/1', expected '.*/3'.*render"
    ):
        dataset({"robot": ROBOT, "rendered_episodes": {"towel": artifact}}, tmp_path / "out", CONFIG)


def test_keypoints_cover_the_garment_and_come_in_one_order():
    line = np.c_[np.linspace(0, 1, 11), np.zeros((11, 2))]
    assert keypoint_indices(line, 3).tolist() == [0, 10, 5]
    with pytest.raises(ValueError, match="12 keypoints among 11"):
        keypoint_indices(line, 12)
