"""The stage of the video discriminator: when it decides, when it abstains, what it refuses."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from validity_synthetic import TESTED, TINY, USUAL, make_artifacts, names, run

import sim1.validity.examples
import sim1.validity.watching
from sim1.episode import episode_folders
from sim1.stage import BadInput
from sim1.validity.stage import (
    StateRulesConfig,
    VideoDiscriminatorConfig,
    check_video_discriminator,
    state_rules,
    valid_trajectories,
    video_discriminator,
)


def test_the_discriminator_abstains_with_too_few_failures_and_says_so(world):
    root, _ = world
    model = json.loads((root / "video_discriminator" / "model.json").read_text())
    assert model["abstains"]
    assert "too few clips: 7 successes and 1 failures" in model["reason"]
    assert names(check_video_discriminator(root / "video_discriminator"), passed=False) == {"decides"}


def test_video_of_another_size_is_refused_before_anything_is_learned(world, tmp_path):
    _, inputs = world
    wider = replace(TINY, frame_width=48)
    with pytest.raises(BadInput, match=r"episodes/0000: the video has frames of 32 x 32 px, .* is for 48 x 32; give"):
        run(video_discriminator, inputs, tmp_path / "out", wider)


def test_what_was_learned_from_another_size_does_not_decide(world, tmp_path):
    root, inputs = world
    trained = shutil.copytree(root / "video_discriminator", tmp_path / "trained")
    model = json.loads((trained / "model.json").read_text())
    (trained / "model.json").write_text(json.dumps(model | {"frame_height": 48}))
    with pytest.raises(BadInput, match=r"episodes/0000: the video has frames of 32 x 32 px, .* is for 32 x 48; give"):
        run(valid_trajectories, {**inputs, "video_discriminator": {"sheet": trained}}, tmp_path / "out", USUAL)


def test_a_missing_class_makes_it_abstain_without_a_network(tmp_path):
    inputs = make_artifacts(tmp_path, [1.0], [1.0, 0.99])
    run(video_discriminator, inputs, tmp_path / "out", TINY)
    model = json.loads((tmp_path / "out" / "model.json").read_text())
    assert model["abstains"]
    assert not model["trained"]
    assert "one class is missing: 3 successes and 0 failures" in model["reason"]


LEARNS = VideoDiscriminatorConfig(
    step_count=25, frame_count=4, frame_width=32, frame_height=32, batch_size=6, width=16, learning_rate=1e-3
)


@pytest.fixture(scope="module")
def deciding(tmp_path_factory):
    """A discriminator that has seen enough of both: three demonstrations, fifteen good candidates and fifteen bad ones."""
    root = tmp_path_factory.mktemp("deciding")
    inputs = make_artifacts(root, [1.0, 0.98, 0.99], [0.97, 0.25] * 15)
    run(video_discriminator, inputs, root / "out", LEARNS)
    return root / "out"


def test_the_discriminator_decides_once_clips_of_other_demonstrations_support_it(deciding):
    metrics = json.loads((deciding / "metrics.json").read_text())
    assert not metrics["abstains"], metrics["reason"]
    assert metrics["test"]["precision"] >= LEARNS.precision
    who = metrics["demonstrations"]
    for part in ("calibration", "test"):
        [demo] = who[part]
        assert f"demo/{demo}" in [row["clip"] for row in metrics["scores"] if row["part"] == part]
    assert sorted(name for part in who.values() for name in part) == ["0000", "0001", "0002"]
    assert not names(check_video_discriminator(deciding), passed=False)


def test_candidates_of_two_steps_that_mix_demonstrations_of_two_parts_are_left_out_and_counted(tmp_path):
    inputs = make_artifacts(tmp_path, [1.0, 0.98, 0.99], [0.97, 0.25] * 15)
    for index, folder in enumerate(episode_folders(inputs["candidate_trajectories"]["sheet"])):
        about = json.loads((folder / "episode.json").read_text())
        about["sources"] = sorted({f"{index % 3:04d}", f"{index // 3 % 3:04d}"})
        (folder / "episode.json").write_text(json.dumps(about))
    facts = run(video_discriminator, inputs, tmp_path / "out", TINY)
    metrics = json.loads((tmp_path / "out" / "metrics.json").read_text())
    mixed = [f"candidate/{index:04d}" for index in range(30) if index % 3 != index // 3 % 3]
    assert {row["clip"] for row in metrics["scores"] if row["part"] is None} == set(mixed)
    assert facts["left_out_clips"] == metrics["left_out"]["clip_count"] == len(mixed)
    assert f"{len(mixed)} mix demonstrations of different parts and are left out" in metrics["reason"]
    assert sorted(name for part in metrics["demonstrations"].values() for name in part) == ["0000", "0001", "0002"]


def test_a_candidate_that_hides_what_it_is_made_of_is_refused(tmp_path):
    inputs = make_artifacts(tmp_path, [1.0], [0.97])
    file = inputs["candidate_trajectories"]["sheet"] / "episodes" / "0000" / "episode.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | {"sources": []}))
    with pytest.raises(
        BadInput, match=r"episodes/0000/episode\.json: sources is \[\], .*make candidate_trajectories again"
    ):
        run(state_rules, inputs, tmp_path / "out", StateRulesConfig())


def test_a_discriminator_that_decides_against_its_test_clips_is_found(deciding, tmp_path):
    """The threshold suits the calibration clips; of the test clips it accepts, as many are failures as successes."""
    out = shutil.copytree(deciding, tmp_path / "out")
    metrics = json.loads((out / "metrics.json").read_text())
    for row in metrics["scores"]:
        if row["part"] == "test" and not row["success"]:
            row["score"] = 0.999
    (out / "metrics.json").write_text(json.dumps(metrics))
    [finding] = [item for item in check_video_discriminator(out) if item.name == "decides_only_with_evidence"]
    assert finding.blocking
    assert not finding.passed
    assert "not surely more than accepting all gives" in finding.detail


def test_a_threshold_that_fails_on_the_test_clips_makes_it_abstain(tmp_path, monkeypatch):
    """The network is replaced by one that tells the clips of its calibration and knows nothing of others."""
    inputs = make_artifacts(tmp_path, [1.0, 0.98, 0.99], [0.97, 0.25] * 15)
    real = sim1.validity.watching.scores

    def guessed(network, clips):
        found = real(network, clips)
        return np.where(np.arange(len(found)) % 3 == TESTED, 0.9, found)  # demonstration i % 3 of both kinds of clips

    monkeypatch.setattr(sim1.validity.watching, "scores", guessed)
    run(video_discriminator, inputs, tmp_path / "out", LEARNS)
    metrics = json.loads((tmp_path / "out" / "metrics.json").read_text())
    assert metrics["demonstrations"]["test"] == [f"{TESTED:04d}"]
    assert metrics["calibration"]["precision"] >= LEARNS.precision
    assert metrics["abstains"]
    assert "not surely more than accepting all gives" in metrics["reason"]
    assert names(check_video_discriminator(tmp_path / "out"), passed=False) == {"decides"}
