"""Attempts until enough pass the filters, in a folder that knows what it was begun with."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from sim1.motion import algorithm
from sim1.motion.algorithm import Checked, generate_until
from sim1.motion.stage import CandidateTrajectoriesConfig
from sim1.quota import Ticket
from sim1.stage import BadInput
from sim1.validity.stage import ValidTrajectoriesConfig

CODE = {"candidate_trajectories": "made:here, version 7", "valid_trajectories": "decided:here, version 4"}
CONFIGS = (CandidateTrajectoriesConfig(seed=1), ValidTrajectoriesConfig())
NOTHING = {
    "rules_pass": True, "rules_broken": "", "video_score": None, "video_pass": False, "video_abstains": True, "reasons": ""
}  # fmt: skip


def outcome(monkeypatch, tmp_path, row, said):
    monkeypatch.setattr(algorithm, "decision", lambda *given: NOTHING | said)
    bench = SimpleNamespace(make=lambda ticket, folder: {"ran": True, "failure": None, "success": True} | row)
    return Checked(bench=bench, filters=None).make(Ticket(series="", number=0), tmp_path)


@pytest.mark.parametrize(
    ("row", "said", "failure"),
    [
        ({}, {"accepted": True}, None),
        ({}, {"accepted": False, "reasons": "rules: end.height_p99_m <= 0.05, is 0.09"}, "rejected by rule"),
        ({}, {"accepted": False, "reasons": "video: score 0.2 below 0.5"}, "rejected by video"),
        ({"failure": "slip", "success": False}, {"accepted": False, "reasons": "judge: slip; rules: anything"}, "slip"),
    ],
)
def test_a_failure_has_the_class_of_what_came_first(monkeypatch, tmp_path, row, said, failure):
    assert outcome(monkeypatch, tmp_path, row, said)["failure"] == failure


@pytest.fixture
def begun(monkeypatch, tmp_path):
    """Generates with toy attempts, every second of which is accepted unless told otherwise."""
    monkeypatch.setattr(algorithm, "write_tables", lambda *given: None)
    monkeypatch.setattr(algorithm, "read_start", lambda path: None)

    def generate(target=3, configs=CONFIGS, versions=None, code=CODE, every=2, ran=False):
        def make(ticket, folder):
            return {"ran": ran, "accepted": (ticket.number + 1) % every == 0, "episode": ticket.name}

        monkeypatch.setattr(Checked, "of", lambda *given: SimpleNamespace(make=make))
        inputs, out = {"seed_demos": {"towel": tmp_path}}, tmp_path / "out"
        made_from = versions or {"seed_demos": "a1"}
        return generate_until(inputs, "towel", None, configs, made_from, code, out, target, 1, lambda rows: None)

    return generate


def test_attempts_go_on_until_the_target_is_accepted_and_all_are_kept(begun, tmp_path):
    rows = begun()
    assert [row["accepted"] for row in rows] == [False, True] * 3
    assert len(list((tmp_path / "out" / "attempts").iterdir())) == 6
    assert not (tmp_path / "out" / "work").exists()


def test_a_larger_target_goes_on(begun):
    assert len(begun(target=1)) == 2
    assert len(begun(target=4)) == 8


@pytest.mark.parametrize("ran", [False, True])
def test_of_what_never_passes_so_many_attempts_are_made_for_each_wanted_episode(begun, monkeypatch, ran):
    assert algorithm.TRIES_PER_TARGET == 100  # README.md and docs/motion.md say so
    monkeypatch.setattr(algorithm, "TRIES_PER_TARGET", 3)
    rows = begun(target=2, every=99, ran=ran)
    assert [row["episode"] for row in rows] == [f"{number:04d}" for number in range(6)]
    assert not any(row["accepted"] for row in rows)


def test_the_last_attempt_below_the_limit_still_counts(begun, monkeypatch):
    monkeypatch.setattr(algorithm, "TRIES_PER_TARGET", 3)
    assert [row["accepted"] for row in begun(target=2, every=3)] == [False, False, True] * 2


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"versions": {"seed_demos": "b2"}}, "input.seed_demos was a1 .* is b2"),
        ({"configs": (CandidateTrajectoriesConfig(seed=4), CONFIGS[1])}, "setting.seed was 1"),
        ({"configs": (CONFIGS[0], ValidTrajectoriesConfig(use_video=False))}, "filter.use_video was True"),
        (
            {"code": CODE | {"candidate_trajectories": "made:here, version 8"}},
            "code.candidate_trajectories was made:here, version 7 .* is made:here, version 8 now; give another folder",
        ),
    ],
)
def test_a_folder_that_was_begun_with_something_else_is_refused_and_kept(begun, tmp_path, changed, named):
    begun()
    before = (tmp_path / "out" / "plan.json").read_text()
    with pytest.raises(BadInput, match=named):
        begun(**changed)
    assert (tmp_path / "out" / "plan.json").read_text() == before
    assert json.loads(before)["garment"] == "towel"


def test_of_two_that_begin_a_folder_at_once_the_later_is_held_to_what_the_first_noted(begun, tmp_path, monkeypatch):
    link = Path.hardlink_to

    def beaten(path, part):
        path.write_text(json.dumps(json.loads(part.read_text()) | {"setting.seed": 9}))
        return link(path, part)

    monkeypatch.setattr(Path, "hardlink_to", beaten)
    with pytest.raises(BadInput, match=r"setting\.seed was 9"):
        begun()
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["plan.json"]


@pytest.mark.parametrize("damaged", ["", '{"garment": "to', "[]", "3"])
def test_a_damaged_plan_is_named_with_what_to_do(begun, tmp_path, damaged):
    begun()
    (tmp_path / "out" / "plan.json").write_text(damaged)
    with pytest.raises(BadInput, match=r"plan\.json: not readable.*another folder, or remove"):
        begun()


def test_a_folder_of_code_that_did_not_note_its_version_is_refused(begun, tmp_path):
    begun()
    plan = json.loads((tmp_path / "out" / "plan.json").read_text())
    older = {name: value for name, value in plan.items() if not name.startswith("code.")}
    (tmp_path / "out" / "plan.json").write_text(json.dumps(older))
    with pytest.raises(BadInput, match="candidate_trajectories was not noted when this folder was begun"):
        begun()


def test_counts_of_the_stage_have_no_say(begun):
    begun()
    begun(configs=(CandidateTrajectoriesConfig(seed=1, candidate_count=9, run_limit=2), CONFIGS[1]))
