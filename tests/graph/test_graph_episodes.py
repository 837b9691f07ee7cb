"""`sim1 generate` and `sim1 replay`: what they are asked for and cannot do is one line."""

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest

from assets_defs import _config, _generate, _store
from assets_defs._generate import code_of, given, refuse_seed_learned_from
from assets_defs._origin import Origin, inputs_then, origin_of
from assets_defs._replay import CELL
from assets_defs._store import StoreError, place
from pipeline.graph import load_graph
from pipeline.home import REPOSITORY, Home
from sim1.motion import algorithm
from sim1.motion.algorithm import Checked
from sim1.motion.stage import CandidateTrajectoriesConfig
from sim1.stage import BadInput


def test_generating_needs_a_garment_that_there_is(project):
    answer = project.command("generate", "glove", "--target", "3")
    assert answer.returncode == 2
    assert "glove: there is no data/garments/glove.yaml; there are ['shirt', 'towel']" in answer.stderr


@pytest.fixture
def generate(project, monkeypatch):
    """`sim1 generate` of two episodes, with three attempts for each, which cost nothing and all end alike."""
    graph = load_graph(Home(REPOSITORY), "smoke")
    nodes = [graph.nodes[name] for name in ("candidate_trajectories", "valid_trajectories")]
    inputs = {"seed_demos": {"towel": project.root}}
    monkeypatch.setattr(_generate, "given", lambda *asked: (inputs, nodes, {"seed_demos": "a1"}))
    monkeypatch.setattr(algorithm, "TRIES_PER_TARGET", 3)
    monkeypatch.setattr(algorithm, "read_start", lambda path: None)
    monkeypatch.setattr(algorithm, "write_tables", lambda *given: None)

    def command(row):
        filters = {"rules_pass": True, "video_pass": False, "video_abstains": True}
        maker = SimpleNamespace(make=lambda ticket, folder: {"ran": True, "episode": ticket.name} | filters | row)
        monkeypatch.setattr(Checked, "of", lambda *given: maker)
        return project.command("generate", "towel", "--target", "2", "--workers", "1")

    return command


def test_generating_ends_with_status_1_where_the_limit_of_attempts_comes_first(generate):
    answer = generate({"success": False, "accepted": False, "failure": "slip"})
    assert answer.returncode == 1
    assert "accepted: 0 of 6 = 0 %" in answer.stdout
    assert "  slip: 6" in answer.stdout.splitlines()
    assert "sim1: 0 of 2 after 6 attempts, the limit" in answer.stderr


def test_generating_ends_well_with_enough_episodes(generate):
    answer = generate({"success": True, "accepted": True, "failure": None})
    assert answer.returncode == 0
    assert "accepted: 2 of 2 = 100 %" in answer.stdout
    assert answer.stderr == ""


@pytest.mark.parametrize("seed", [0, 1])
def test_a_seed_whose_attempts_the_filters_have_learned_from_is_refused(tmp_path, seed):
    home = home_with(tmp_path, f"candidate_trajectories: {{seed: {seed}}}\n")
    graph = load_graph(home, "own")
    said = rf"--seed {seed}: candidate_trajectories in the profile in force has seed {seed} too.*; give --seed {seed + 1}, or"
    with pytest.raises(BadInput, match=said):
        given(home, graph, "towel", None, seed)
    with pytest.raises(StoreError, match="the artifact is missing"):  # it goes on with another one
        given(home, graph, "towel", None, seed + 1)


def test_also_the_seed_of_attempts_that_another_profile_made_is_refused(tmp_path):
    home = home_with(tmp_path, "{}\n")
    node = load_graph(home, "own").nodes["candidate_trajectories"]
    made = place(home, node, "towel").final
    made.mkdir(parents=True)
    (made / "artifact.json").write_text(json.dumps({"parts": {"config": {"seed": 1}}}))
    with pytest.raises(BadInput, match=r"--seed 1: candidate_trajectories/towel in the store has seed 1 too"):
        refuse_seed_learned_from(home, node, "towel", 1)
    refuse_seed_learned_from(home, node, "towel", 2)


def home_with(root: Path, profile: str) -> Home:
    """The project's stages and garments in a folder of its own, with one more profile."""
    for name in ("pipeline", "data/garments"):
        shutil.copytree(REPOSITORY / name, root / name)
    (root / "pipeline" / "profiles" / "own.yaml").write_text(profile)
    return Home(root)


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
    found = origin_of(tmp_path / "episodes" / "0001")
    assert (found.variant, found.garment, found.settings, found.versions) == (
        "slicing",
        "towel",
        {"seed": 3},
        {"scene": "a1"},
    )


def test_a_generated_episode_knows_what_made_it(tmp_path):
    plan = {"variant": None, "garment": "towel", "setting.seed": 1, "filter.use_rules": True, "input.scene": "a1"}
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    found = origin_of(tmp_path / "episodes" / "0001")
    assert (found.stage, found.settings, found.versions) == ("candidate_trajectories", {"seed": 1}, {"scene": "a1"})


def test_a_folder_that_goes_on_knows_the_code_of_both_stages():
    graph = load_graph(Home(REPOSITORY), "smoke")
    code = code_of([graph.nodes[name] for name in ("candidate_trajectories", "valid_trajectories")])
    versions = {name: graph.nodes[name].stage.version for name in code}
    assert code == {
        "candidate_trajectories": f"sim1.motion.stage:candidate_trajectories, version {versions['candidate_trajectories']}",
        "valid_trajectories": f"sim1.validity.stage:valid_trajectories, version {versions['valid_trajectories']}",
    }


def test_an_episode_of_the_stand_in_reality_is_replayed_where_it_lies(tmp_path):
    record = {
        "stage": "real_demos",
        "variant": None,
        "garment": "towel",
        "parts": {"config": {}, "made_from": {"scene:scene/towel": "a1", "reality:reality/towel": "b1"}},
    }
    (tmp_path / "artifact.json").write_text(json.dumps(record))
    assert origin_of(tmp_path / "episodes" / "0001").stage == "real_demos"


@pytest.fixture
def recalibrated(monkeypatch):
    """A graph whose fabric was calibrated anew since an episode was made; what else it was made from is as it was."""
    needs = {name: name for name in ("garment_mesh", "scene", "calibrated_physics")}
    graph = SimpleNamespace(nodes={"candidate_trajectories": SimpleNamespace(needs=needs)} | {n: n for n in needs})
    versions = dict.fromkeys(needs, "a1")
    now = versions | {"calibrated_physics": "b2"}
    monkeypatch.setattr(_store, "verified", lambda home, node, garment: (Path(node), {"data_version": now[node]}))
    monkeypatch.setattr(_config, "config_of", lambda node: CandidateTrajectoriesConfig())
    stage = "candidate_trajectories"
    return graph, Origin(stage=stage, variant=None, garment="towel", settings={"seed": 3}, versions=versions)


def test_commands_are_replayed_also_after_a_calibration(recalibrated, tmp_path):
    inputs, _ = inputs_then(None, recalibrated[0], tmp_path, recalibrated[1], CELL)
    assert inputs == {name: {"towel": Path(name)} for name in ("garment_mesh", "scene")}


def test_planning_anew_needs_the_calibration_that_there_was(recalibrated, tmp_path):
    with pytest.raises(BadInput, match=r"was made from version a1 of calibrated_physics, the store has b2"):
        inputs_then(None, recalibrated[0], tmp_path, recalibrated[1])


def test_a_copy_points_to_where_the_episode_was_simulated(tmp_path):
    (tmp_path / "artifact.json").write_text(json.dumps({"stage": "valid_trajectories"}))
    with pytest.raises(BadInput, match="episode of candidate_trajectories of the same name"):
        origin_of(tmp_path / "episodes" / "0001")
