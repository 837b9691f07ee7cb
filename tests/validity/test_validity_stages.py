import json
import shutil
import weakref

import numpy as np
import pandas as pd
import pytest
from validity_synthetic import TINY, USUAL, make_artifacts, names, run

import sim1.validity.examples
import sim1.validity.watching
from sim1.episode import episode_folders, read_episode
from sim1.stage import BadInput
from sim1.validity.deciding import compared_filters
from sim1.validity.rules import admissible, learn_rules
from sim1.validity.stage import (
    StateRulesConfig,
    ValidTrajectoriesConfig,
    check_state_rules,
    check_valid_trajectories,
    state_rules,
    valid_trajectories,
    video_discriminator,
)


def test_rules_admit_the_successes_and_reject_the_half_fold(world):
    root, _ = world
    assert not names(check_state_rules(root / "state_rules"), passed=False)
    record = json.loads((root / "state_rules" / "training.json").read_text())
    assert record["method"] == "intervals"
    assert record["failures_rejected"].startswith("1 of 1")


def test_left_out_figures_leave_out_a_demonstration_with_all_that_descends_from_it(tmp_path):
    """What descends from 0002 folds by 0.92, unlike all else: only rules that saw its kin admit it."""
    inputs = make_artifacts(tmp_path, [1.0, 0.99, 0.92], [1.0, 0.99, 0.92] * 2)
    run(state_rules, inputs, tmp_path / "out", StateRulesConfig(margin=0.0, recall_floor=1.0))
    features = pd.read_parquet(tmp_path / "out" / "features.parquet").set_index("example")
    kin = ["demo/0002", "candidate/0002", "candidate/0005"]
    assert features.loc[kin, "success"].all()
    record = json.loads((tmp_path / "out" / "training.json").read_text())
    config = StateRulesConfig(margin=0.0, recall_floor=1.0)
    plain = features.drop(columns=["success", "perturbed"])
    admitted = 0
    for source in range(3):
        own = [f"demo/{source:04d}", f"candidate/{source:04d}", f"candidate/{source + 3:04d}"]
        others = plain.drop(own)
        rules = learn_rules(
            others, np.ones(len(others), bool), depth=config.depth, recall_floor=1.0, margin=0.0, minimum_per_class=8
        )
        admitted += int(admissible(rules, plain.loc[own]).sum())
    assert record["successes_admitted_left_out"].startswith(f"{admitted} of 9")
    assert admitted <= 6


@pytest.mark.parametrize("failure", ["unreachable", "out of view"])
def test_rules_learn_nothing_from_runs_cut_short_or_out_of_view_however_well_the_garment_lies(tmp_path, failure):
    inputs = make_artifacts(tmp_path, [1.0, 0.99], [1.0, 0.99, 0.5])
    candidates = inputs["candidate_trajectories"]["sheet"]
    cut = json.loads((candidates / "episodes/0001/episode.json").read_text())
    cut |= {"success": False, "failure": failure}
    (candidates / "episodes/0001/episode.json").write_text(json.dumps(cut))
    run(state_rules, inputs, tmp_path / "out", StateRulesConfig())
    features = pd.read_parquet(tmp_path / "out" / "features.parquet").set_index("example")
    assert features.success.to_dict() == {
        "demo/0000": True,
        "demo/0001": True,
        "candidate/0000": True,
        "candidate/0002": False,
    }


def test_what_nothing_succeeded_without_is_not_judged_rather_than_rejected(tmp_path):
    """All that succeeds descends from the one demonstration, as at the size `quick`."""
    inputs = make_artifacts(tmp_path, [1.0], [1.0, 0.97, 0.45])
    run(state_rules, inputs, tmp_path / "out", StateRulesConfig())
    record = json.loads((tmp_path / "out" / "training.json").read_text())
    assert record["successes_admitted_left_out"] == record["failures_rejected_left_out"] == "none tried"
    assert record["not_judged_left_out"] == 4


def test_good_candidates_are_copied_and_the_bad_one_is_explained(world, tmp_path):
    _, inputs = world
    out = tmp_path / "valid"
    run(valid_trajectories, inputs, out, USUAL)
    table = pd.read_parquet(out / "decisions.parquet").set_index("episode")
    assert table.accepted.to_dict() == {"0000": True, "0001": True, "0002": True, "0003": True, "0004": False}
    assert "judge: not folded" in table.loc["0004", "reasons"]
    assert "rules: " in table.loc["0004", "reasons"]
    assert [folder.name for folder in episode_folders(out)] == ["0000", "0001", "0002", "0003"]
    assert (out / "episodes/0000/video.npz").exists()
    assert (out / "film_strips.png").exists()
    assert not names(check_valid_trajectories(out), passed=False)


def test_attempts_disturbed_on_purpose_are_no_part_of_the_shares_and_are_told_by_themselves(world, tmp_path):
    _, inputs = world
    candidates = shutil.copytree(inputs["candidate_trajectories"]["sheet"], tmp_path / "candidates")
    attempts = pd.read_parquet(candidates / "attempts.parquet")
    attempts["perturbed"] = attempts.episode.isin(["0003", "0004"])  # a good fold and the half one
    attempts.to_parquet(candidates / "attempts.parquet")
    facts = run(
        valid_trajectories, {**inputs, "candidate_trajectories": {"sheet": candidates}}, tmp_path / "out", USUAL
    )
    meant = ("accepted", "judged_successful", "pass_rules")
    assert [facts[name].split(" =")[0] for name in meant] == ["3 of 3"] * 3
    assert facts["disturbed_on_purpose_accepted"].startswith("1 of 2")
    assert len(episode_folders(tmp_path / "out")) == 4


def test_figures_of_the_filters_say_that_they_are_of_attempts_that_the_filters_learned_from(world, tmp_path):
    _, inputs = world
    facts = run(valid_trajectories, inputs, tmp_path / "out", USUAL)
    assert "filters" not in facts
    [rules] = facts["filters_on_attempts_that_they_learned_from"]
    assert (rules["filter"], rules["recall"].split(" =")[0]) == ("state rules alone", "4 of 4")


def test_filters_can_be_switched_off_one_by_one(world, tmp_path):
    _, inputs = world
    accepted = {}
    for name, config in {
        "none": ValidTrajectoriesConfig(require_success=False, use_rules=False, use_video=False),
        "rules": ValidTrajectoriesConfig(require_success=False, use_video=False),
        "judge": ValidTrajectoriesConfig(use_rules=False, use_video=False),
    }.items():
        run(valid_trajectories, inputs, tmp_path / name, config)
        accepted[name] = int(pd.read_parquet(tmp_path / name / "decisions.parquet").accepted.sum())
    assert accepted == {"none": 5, "rules": 4, "judge": 4}


def test_nothing_accepted_is_a_blocking_finding_with_the_reasons(tmp_path):
    inputs = make_artifacts(tmp_path, [1.0, 0.98], [0.4, 0.5])
    for stage, config in ((state_rules, StateRulesConfig()), (video_discriminator, TINY)):
        run(stage, inputs, tmp_path / stage.__name__, config)
        inputs[stage.__name__] = {"sheet": tmp_path / stage.__name__}
    run(valid_trajectories, inputs, tmp_path / "valid", USUAL)
    finding = next(item for item in check_valid_trajectories(tmp_path / "valid") if item.name == "something_accepted")
    assert finding.blocking
    assert not finding.passed
    assert "judge: not folded" in finding.detail


def test_rules_need_a_success(tmp_path):
    inputs = make_artifacts(tmp_path, [0.5], [0.4])
    with pytest.raises(BadInput, match="no successful run"):
        run(state_rules, inputs, tmp_path / "out", StateRulesConfig())


def test_a_broken_floor_is_found(world, tmp_path):
    root, _ = world
    for name in ("rules.yaml", "features.parquet", "training.json"):
        (tmp_path / name).write_bytes((root / "state_rules" / name).read_bytes())
    text = (tmp_path / "rules.yaml").read_text().replace("above: 0", "above: 90", 1)
    (tmp_path / "rules.yaml").write_text(text)
    assert "recall_floor" in names(check_state_rules(tmp_path), passed=False)


@pytest.mark.parametrize(("stage", "config"), [(state_rules, StateRulesConfig()), (video_discriminator, TINY)])
def test_of_many_trajectories_hardly_more_than_one_is_held_at_once(world, tmp_path, monkeypatch, stage, config):
    _, inputs = world
    read, held = [], []

    def reading(folder):
        held.append(sum(garment_m() is not None for garment_m in read))
        episode = read_episode(folder)
        read.append(weakref.ref(episode.garment_m))
        return episode

    monkeypatch.setattr(sim1.validity.examples, "read_episode", reading)
    run(stage, inputs, tmp_path / "out", config)
    assert len(held) == 8
    assert max(held) == 1  # the one before, while the next is read


def test_stages_write_the_same_bytes_again(world, tmp_path):
    root, inputs = world
    run(state_rules, inputs, tmp_path / "rules", StateRulesConfig())
    run(video_discriminator, inputs, tmp_path / "video", TINY)
    for one, two in ((root / "state_rules", tmp_path / "rules"), (root / "video_discriminator", tmp_path / "video")):
        for path in sorted(one.iterdir()):
            assert path.read_bytes() == (two / path.name).read_bytes(), path.name
    assert np.isfinite(pd.read_parquet(root / "state_rules/features.parquet").select_dtypes("number")).all().all()


def test_filters_are_compared_with_the_judge_one_by_one_and_together():
    columns = ("ran", "success", "rules_pass", "video_pass")
    table = [(1, 1, 1, 1), (1, 1, 1, 0), (1, 1, 0, 1), (1, 0, 1, 0), (1, 0, 0, 0), (0, 0, 0, 0)]
    rows = [dict(zip(columns, map(bool, row), strict=True)) | {"failure": None} for row in table]
    rows.append(rows[3] | {"video_pass": True, "failure": "unreachable"})  # an arm's failure, which no garment shows
    rows = [row | {"video_abstains": False} for row in rows]
    found = {row["filter"]: (row["precision"], row["recall"]) for row in compared_filters(rows)}
    starts = {name: (one.split(" =")[0], two.split(" =")[0]) for name, (one, two) in found.items()}
    assert starts == {
        "state rules alone": ("2 of 3", "2 of 3"),
        "video alone": ("2 of 2", "2 of 3"),
        "both": ("1 of 1", "1 of 3"),
    }
    abstaining = [row | {"video_abstains": True} for row in rows]
    assert [row["filter"] for row in compared_filters(abstaining)] == ["state rules alone"]
