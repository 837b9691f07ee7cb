"""The stages on made-up tables; the simulated cell is replaced by one that cannot fail."""

import hashlib
import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from made_up_cell import CONFIG, failed
from made_up_dataset import write_demonstrations

from sim1.policy.lessons import GENERATED, KINDS, REAL
from sim1.policy.model import load_policy, save_policy
from sim1.policy.stage import (
    PolicyConfig,
    ScalingReportConfig,
    check_policy,
    check_scaling_report,
    policy,
    scaling_report,
)
from sim1.progress import listening
from sim1.stage import BadInput


def test_every_model_and_every_trial_is_there(artifact):
    out, facts = artifact
    assert failed(check_policy(out)) == []
    about = json.loads((out / "policy.json").read_text())
    assert about["lessons"][GENERATED]["sizes"] == [2, 4, 6]  # 10 trajectories, 2 of each garment held out
    assert facts["model_count"] == 6
    trials = pd.read_parquet(out / "evaluation.parquet")
    assert len(trials) == 2 * 2 * 2 * 2  # garments, shifts, sizes, trials; one seed drives
    assert not (out / "trials").exists()
    assert set(trials["size"]) == {2, 6}
    assert not trials["success"].any()
    assert set(trials["failure"]) == {"not_folded"}


def test_demonstrations_of_either_world_teach_beside_the_generated_ones_and_real_ones_test_all(
    tmp_path, dataset, bench, trajectories
):
    towels = [item for item in trajectories if item.garment == "towel"]
    demos = {"towel": write_demonstrations(tmp_path / "demos", towels), "tshirt": tmp_path / "none"}
    (tmp_path / "none").mkdir()
    (tmp_path / "none" / "none.json").write_text('{"why": "nobody asked"}')
    out, config = tmp_path / "p", replace(CONFIG, simulated_sizes=(2,), real_sizes=(1, 2))
    out.mkdir()
    policy({"dataset": {"": dataset.path}, "real_demos": demos, "seed_demos": demos}, out, config)
    assert failed(check_policy(out)) == []
    about = json.loads((out / "policy.json").read_text())
    assert about["lessons"][REAL]["sizes"] == [1, 2]  # four that succeeded, one kept to test
    tested = pd.read_parquet(out / "open_loop.parquet")
    pairs = set(tested[["trained_on", "tested_on"]].itertuples(index=False, name=None))
    own = tested[tested["tested_on"] != GENERATED]
    assert (own["source"] == own["tested_on"] + " " + own["trajectory"]).all()  # of no two demonstrations one motion
    assert pairs == {(kind, tested) for kind in KINDS for tested in (kind, REAL)}
    real = tested[tested["tested_on"] == REAL]
    held = set(real["trajectory"])
    sets = about["lessons"][REAL]["training_sets"]["2"]
    assert held.isdisjoint(name.split("/")[1] for training_set in sets.values() for name in training_set)
    assert held.isdisjoint({"0000"})  # it failed
    trials = pd.read_parquet(out / "evaluation.parquet")
    assert set(trials["trained_on"]) == set(KINDS)


def test_every_model_has_learnt_from_the_garments_that_it_drives(tmp_path, dataset, bench, trajectories):
    """Two garments are generated, one of them is demonstrated; a size of one is too small for two."""
    towels = [item for item in trajectories if item.garment == "towel"]
    demos = {"towel": write_demonstrations(tmp_path / "demos", towels)}
    out, config = tmp_path / "p", replace(CONFIG, sizes=(1, 4), real_sizes=(1, 2), seeds=(0,), trial_count=1)
    out.mkdir()
    policy({"dataset": {"": dataset.path}, "real_demos": demos}, out, config)
    about = json.loads((out / "policy.json").read_text())
    assert {kind: lesson["sizes"] for kind, lesson in about["lessons"].items()} == {GENERATED: [2, 4], REAL: [1, 2]}
    assert about["lessons"][GENERATED]["requested_sizes"] == [1, 4]
    trials = pd.read_parquet(out / "evaluation.parquet")
    assert trials.groupby("garment")["trained_on"].unique().map(set).to_dict() == {
        "towel": {GENERATED, REAL},
        "tshirt": {GENERATED},
    }
    for trial in trials.itertuples():
        training_set = about["lessons"][trial.trained_on]["training_sets"][str(trial.size)][str(trial.seed)]
        assert trial.garment in {name.split("/")[0] for name in training_set}


def test_the_check_sees_a_garment_that_a_model_was_not_shown(artifact):
    path = artifact[0] / "policy.json"
    about = json.loads(path.read_text())
    sets = about["lessons"][GENERATED]["training_sets"]
    sets["2"]["0"] = [name for name in sets["2"]["0"] if not name.startswith("towel/")]
    path.write_text(json.dumps(about))
    assert failed(check_policy(artifact[0])) == ["nobody_drives_what_it_was_not_shown"]


def test_without_real_demonstrations_it_is_said_why(tmp_path, dataset, bench):
    (tmp_path / "none").mkdir()
    (tmp_path / "none" / "none.json").write_text('{"why": "nobody asked"}')
    (tmp_path / "p").mkdir()
    policy({"dataset": {"": dataset.path}, "real_demos": {"towel": tmp_path / "none"}}, tmp_path / "p", CONFIG)
    assert json.loads((tmp_path / "p" / "policy.json").read_text())["no_real_demonstrations"] == "nobody asked"
    (tmp_path / "s").mkdir()
    scaling_report({"policy": {"": tmp_path / "p"}}, tmp_path / "s", ScalingReportConfig())
    assert "nobody asked" in (tmp_path / "s" / "report.html").read_text()


def test_demonstrations_that_nobody_asks_to_learn_from_are_not_said_to_be_missing(
    tmp_path, dataset, bench, trajectories
):
    demos = {"towel": write_demonstrations(tmp_path / "demos", trajectories[:3])}
    (tmp_path / "p").mkdir()
    policy({"dataset": {"": dataset.path}, "real_demos": demos}, tmp_path / "p", replace(CONFIG, real_sizes=()))
    said = json.loads((tmp_path / "p" / "policy.json").read_text())["no_real_demonstrations"]
    assert said == "none were asked for"


def test_the_fact_of_standing_still_is_of_the_trajectories_that_the_error_beside_it_is_of(
    tmp_path, dataset, bench, trajectories
):
    demos = {"towel": write_demonstrations(tmp_path / "demos", trajectories[:4])}
    (tmp_path / "p").mkdir()
    facts = policy({"dataset": {"": dataset.path}, "real_demos": demos}, tmp_path / "p", CONFIG)
    tested = pd.read_parquet(tmp_path / "p" / "open_loop.parquet")
    own = tested[(tested["trained_on"] == GENERATED) & (tested["tested_on"] == GENERATED) & (tested["size"] == 6)]
    assert facts["standing_still_joint_error_rad"] == pytest.approx(own["hold_joint_error_rad"].mean())
    assert facts["standing_still_joint_error_rad"] != pytest.approx(tested["hold_joint_error_rad"].mean())


def test_a_network_that_diverges_is_named_with_the_setting_before_it_drives(tmp_path, dataset, bench):
    with pytest.raises(
        BadInput, match=r"seed 0: its weights are not finite after 60 steps; set a smaller learning_rate than 1e\+20"
    ):
        policy({"dataset": {"": dataset.path}}, tmp_path, replace(CONFIG, learning_rate=1e20))


@pytest.mark.parametrize(
    "settings",
    [
        {"seeds": ()},
        {"seeds": (1, 1)},
        {"shifts": ("spatial", "spatial")},
        {"friction_factors": ()},
        {"friction_factors": (-1.0,)},
    ],
)
def test_settings_that_no_trial_can_follow_are_refused_before_anything_is_trained(settings):
    with pytest.raises(ValueError, match=next(iter(settings))):
        PolicyConfig(**settings)


def test_held_out_trajectories_never_train(artifact, dataset):
    about = json.loads((artifact[0] / "policy.json").read_text())
    tested = pd.read_parquet(artifact[0] / "open_loop.parquet")
    assert set(tested["source"]) == {"0002"}  # the demonstration that they come from
    lesson = about["lessons"][GENERATED]
    trained = set().union(*lesson["training_sets"][str(max(lesson["sizes"]))].values())
    assert trained.isdisjoint({f"{row.garment}/{row.trajectory}" for row in tested.itertuples()})
    assert [(row["split"], row["held-out sources"]) for row in lesson["splits"]] == 2 * [("source", ["0002"])]


def test_each_network_seed_draws_trajectories_of_its_own_and_learns_from_them(tmp_path, dataset, bench, trajectories):
    """Of one seed smaller sets lie within larger ones; what a network's inputs centre on are the states it was shown."""
    out, config = tmp_path / "p", replace(CONFIG, sizes=(2, 4), seeds=(0, 1, 2, 3), steps=1, trial_count=0)
    out.mkdir()
    policy({"dataset": {"": dataset.path}}, out, config)
    sets = json.loads((out / "policy.json").read_text())["lessons"][GENERATED]["training_sets"]
    assert {frozenset(names) for names in sets["2"].values()} > {frozenset(sets["2"]["0"])}
    for seed in map(str, config.seeds):
        assert sets["4"][seed][:2] == sets["2"][seed]
    known = {f"{item.garment}/{item.name}": item for item in trajectories}
    for size, seed in (("2", 0), ("2", 3), ("4", 1)):
        model = load_policy(out / "policies" / f"generated_{size}_{seed}.safetensors")
        shown = np.concatenate([known[name].state for name in sets[size][str(seed)]])
        np.testing.assert_allclose(model.input_mean[: shown.shape[1]], shown.mean(axis=0), atol=1e-5)


def test_same_config_same_bytes(tmp_path, dataset, bench, artifact):
    again = tmp_path / "again"
    again.mkdir()
    policy({"dataset": {"": dataset.path}}, again, CONFIG)
    for path in sorted(artifact[0].rglob("*")):
        if path.is_file():
            twin = again / path.relative_to(artifact[0])
            assert hashlib.sha256(path.read_bytes()).digest() == hashlib.sha256(twin.read_bytes()).digest(), path.name


def test_progress_rises_from_nothing_to_all(tmp_path, dataset, bench):
    seen = []
    (tmp_path / "p").mkdir()
    with listening(lambda done, total, what: seen.append(done / total)):
        policy({"dataset": {"": dataset.path}}, tmp_path / "p", CONFIG)
    assert seen == sorted(seen)
    assert (seen[0], seen[-1]) == (0.0, 1.0)


def test_checks_see_a_lost_trial_a_lost_model_and_weights_that_are_no_numbers(artifact):
    out, _ = artifact
    trials = pd.read_parquet(out / "evaluation.parquet")
    trials.iloc[1:].to_parquet(out / "evaluation.parquet")
    assert failed(check_policy(out)) == ["every_trial_accounted_for"]
    trials.to_parquet(out / "evaluation.parquet")
    model = load_policy(out / "policies" / "generated_2_0.safetensors")
    model.body[0].weight.data[0, 0] = float("nan")
    save_policy(out / "policies" / "generated_2_0.safetensors", model)
    assert failed(check_policy(out)) == ["weights_finite"]
    (out / "policies" / "generated_2_0.safetensors").unlink()
    assert "every_model_saved" in failed(check_policy(out))


def test_a_dataset_of_nothing_to_train_on_is_refused(tmp_path, dataset):
    with pytest.raises(BadInput, match="no trajectory to train on"):
        policy({"dataset": {"": dataset.path}}, tmp_path, PolicyConfig(sizes=(0,)))


def test_scaling_report_states_its_counts_and_stands_alone(tmp_path, artifact):
    out = tmp_path / "scaling"
    out.mkdir()
    facts = scaling_report({"policy": {"": artifact[0]}}, out, ScalingReportConfig())
    assert failed(check_scaling_report(out)) == []
    assert facts["trial_count"] == 16
    page = (out / "report.html").read_text()
    assert "0 of 4 = 0 % (95 % interval 0 to 49 %)" in page
    assert "scripted expert" in page
    assert "<td>0002</td>" in page  # the demonstrations that are held out
    assert "Not known" in page
    assert "of one network what others would err is not in them" in page
    assert "demonstrations: 2; standing still" in page  # of either garment one
    assert "as many demonstrations as there are" in page.replace("\n", " ")
    assert "Every seed draws trajectories of its own to train on" in page
    page = page.replace("\N{NO-BREAK SPACE}", " ").replace("0 of 4", "4 of 4")
    (out / "report.html").write_text(page + '<img src="https://example.org/x.png">')
    assert failed(check_scaling_report(out)) == ["page_states_its_counts", "page_stands_alone"]


def test_figures_of_an_earlier_version_or_damaged_are_refused_not_misread(tmp_path, artifact):
    path = artifact[0] / "policy.json"
    earlier = json.dumps(json.loads(path.read_text()) | {"schema": "sim1.policy_result/2"})
    for content, said in ((earlier, "schema is 'sim1.policy_result/2', expected"), ("{", "not readable")):
        path.write_text(content)
        for read in (check_policy, lambda p: scaling_report({"policy": {"": p}}, tmp_path, ScalingReportConfig())):
            with pytest.raises(BadInput, match=rf"policy\.json: {said}.*make policy again"):
                read(artifact[0])


def test_check_sees_a_success_outside_its_interval_and_shifts_that_do_not_add_up(tmp_path, artifact):
    out = tmp_path / "scaling"
    out.mkdir()
    scaling_report({"policy": {"": artifact[0]}}, out, ScalingReportConfig())
    curve = json.loads((out / "curve.json").read_text())
    curve["points"][0]["trials"][0]["interval"] = [0.5, 0.9]
    curve["points"][0]["all_trials"]["trial_count"] += 1
    (out / "curve.json").write_text(json.dumps(curve))
    assert failed(check_scaling_report(out)) == ["intervals_hold_their_values", "shifts_add_up"]
