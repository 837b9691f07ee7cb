"""`sim1 generate` and `sim1 replay`: what they are asked for and cannot do is one line."""

import json

import pytest

from assets_defs._replay import _origin
from sim1.stage import BadInput


def test_generating_needs_a_garment_that_there_is(project):
    answer = project.command("generate", "glove", "--target", "3")
    assert answer.returncode == 2
    assert "glove: there is no data/garments/glove.yaml; there are ['shirt', 'towel']" in answer.stderr


def test_an_episode_of_no_artifact_is_named_with_where_they_lie(project):
    answer = project.command("replay", str(project.root / "data"))
    assert answer.returncode == 2
    assert "data/store/STAGE/GARMENT/episodes/NNNN" in answer.stderr


def test_an_episode_of_an_artifact_knows_what_made_it(tmp_path):
    record = {
        "stage": "candidate_trajectories",
        "variant": "slicing",
        "garment": "towel",
        "parts": {"config": {"seed": 3}, "made_from": {"scene:scene/towel": "a1"}},
    }
    (tmp_path / "artifact.json").write_text(json.dumps(record))
    found = _origin(tmp_path / "episodes" / "0001")
    assert (found.variant, found.garment, found.settings, found.versions) == (
        "slicing",
        "towel",
        {"seed": 3},
        {"scene": "a1"},
    )


def test_a_generated_episode_knows_what_made_it(tmp_path):
    plan = {"variant": None, "garment": "towel", "setting.seed": 1, "filter.use_rules": True, "input.scene": "a1"}
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    found = _origin(tmp_path / "episodes" / "0001")
    assert (found.stage, found.settings, found.versions) == ("candidate_trajectories", {"seed": 1}, {"scene": "a1"})


def test_a_copy_points_to_where_the_episode_was_simulated(tmp_path):
    (tmp_path / "artifact.json").write_text(json.dumps({"stage": "valid_trajectories"}))
    with pytest.raises(BadInput, match="episode of candidate_trajectories of the same name"):
        _origin(tmp_path / "episodes" / "0001")
