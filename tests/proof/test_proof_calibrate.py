"""Thresholds from cases with nothing concealed."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import gumbel_r, norm
from test_proof_score import outcome

from pipeline.home import REPOSITORY
from sim1.data_file import read_data_file
from sim1.mismatch.thresholds import FILE, SCHEMA, THRESHOLDS, Measured, read_thresholds
from sim1.proof.calibrate import calibrated, largest, level_of, tail_of, write_thresholds
from sim1.proof.outcome import Outcome
from sim1.stage import BadInput

GAINS = gumbel_r.rvs(10.0, 12.0, size=60, random_state=0)
LEFT = norm.rvs(1.0, 0.1, size=60, random_state=1)
WORST = gumbel_r.rvs(1.3, 0.05, size=60, random_state=1)


@pytest.fixture(autouse=True)
def few_resamples(monkeypatch):
    """A fit takes a twentieth of a second, and the interval is asked for once."""
    monkeypatch.setattr("sim1.proof.calibrate.RESAMPLES", 20)


def nulls(gains, code="c0de", left=LEFT, by="wind"):
    """Cases with nothing concealed, by what the best effect, `by`, gains and the baseline leaves."""
    made = []
    for number, gain in enumerate(gains):
        case = outcome(f"case_{number:03d}", "null", [], "none")
        changed = {
            "worths": {"the baseline": 0.0, by: float(gain), "plastic_crease": 800.0},
            "gains": {"wind": 2.0 * float(gain), "plastic_crease": 900.0},
            "established": ("wind",),
            "steady": ("the baseline", by),
            "table": number % 3 == 0,
            "misfit": (float(left[number]), 0.9),
            "misfit_alone": float(WORST[number]),
        }
        found = case.found.model_copy(update=changed)
        made.append(case.model_copy(update={"found": found, "seed": number, "code_sha256": code}))
    return made


@pytest.mark.parametrize("share", [1.0, 0.3, 0.005])
def test_what_chance_gains_is_exceeded_by_its_share_of_all_cases_also_where_nothing_stands_in_most(share):
    stream = np.random.default_rng(1)
    gains = np.where(stream.random(200_000) < share, stream.exponential(12.0, size=200_000), 0.0)
    assert np.mean(gains > tail_of(gains)) == pytest.approx(min(share, 0.05 / 4), rel=0.12)


def test_where_nothing_ever_stands_chance_gains_nothing():
    assert tail_of(np.zeros(20)) == 0.0
    assert tail_of(np.array([*np.zeros(20), 30.0])) == pytest.approx(30.0 * np.log(1 / 21 / (0.05 / 4)))


def test_one_case_of_ten_that_gains_far_more_does_not_decide_how_chance_falls_off():
    few = np.array([*np.zeros(30), *np.linspace(2.0, 20.0, 20)])
    assert tail_of(np.where(few == few.max(), 2000.0, few)) == pytest.approx(tail_of(few), rel=0.02)


def test_no_case_seen_would_be_given_a_name():
    far = [*np.zeros(15), 3.0, 90.0]
    assert calibrated(nulls(far)).named >= 90.0


def test_what_motion_held_out_makes_of_chance_counts_as_what_fits_make_of_it():
    cases = nulls(GAINS)
    heard = cases[7].found.model_copy(update={"heard": {"wind": 300.0, "plastic_crease with wind": 900.0}})
    cases[7] = cases[7].model_copy(update={"found": heard})
    assert [null.worth for null in calibrated(cases).nulls][7] == 300.0


def test_a_name_that_motion_held_out_took_back_was_half_as_far_from_being_given():
    cases, before = nulls(GAINS), calibrated(nulls(GAINS)).nulls[7].worth
    cases[7] = cases[7].model_copy(update={"found": cases[7].found.model_copy(update={"withdrawn": ("wind",)})})
    assert before > 10.0
    assert calibrated(cases).nulls[7].worth == pytest.approx(before / THRESHOLDS.alone, abs=0.1)


def test_what_is_no_name_however_much_it_gains_sets_no_threshold():
    """A crease gains 900 nats in every case, and recordings do not agree that it is there."""
    measured = calibrated(nulls(GAINS))
    assert measured.named < 150.0
    assert max(2.0 * GAINS) <= measured.gain < 300.0
    unsteady = [one.model_copy(update={"found": one.found.model_copy(update={"steady": ()})}) for one in nulls(GAINS)]
    unworthy = calibrated(unsteady)
    assert {null.worth for null in unworthy.nulls} == {0.0}
    assert unworthy.gain == measured.gain
    told_less = [
        one.model_copy(update={"found": one.found.model_copy(update={"established": None})}) for one in nulls(GAINS)
    ]
    with pytest.raises(
        BadInput, match=r"outcomes/case_000\.json, of 60 such: scored before it was told which models are steady"
    ):
        calibrated(told_less)


def test_few_cases_would_be_called_unknown_and_a_strange_one_does_not_decide():
    measured = calibrated(nulls(GAINS))
    assert np.mean(measured.misfit > LEFT) > 0.95
    assert norm.ppf(0.97, 1.0, 0.1) < measured.misfit < norm.ppf(0.999, 1.0, 0.1)
    assert gumbel_r.ppf(0.97, 1.3, 0.05) < measured.misfit_alone < gumbel_r.ppf(0.9999, 1.3, 0.05)
    strange = LEFT.copy()
    strange[3] = 3.0
    assert calibrated(nulls(GAINS, left=strange)).misfit < 1.5


def test_of_many_such_cases_one_in_twenty_at_most_exceeds_any_of_the_four():
    stream = np.random.default_rng(2)
    any_of = np.zeros(20_000, bool)
    for values in (gumbel_r.rvs(0.0, 1.0, size=20_000, random_state=stream) for _ in range(4)):
        any_of |= values > level_of(values + 20.0) - 20.0
    assert any_of.mean() == pytest.approx(0.05, abs=0.005)


def test_the_best_single_effect_counts_not_the_baseline_or_pairs():
    worths = {"the baseline": 0.0, "wind": 12.0, "grip_slip": 20.0, "grip_slip with wind": 31.0}
    assert largest(worths) == 20.0
    assert largest({"the baseline": 0.0, "wind": -4.0}) == 0.0


def test_what_is_written_is_what_a_diagnosis_reads_with_the_seeds_that_made_it(tmp_path):
    measured = calibrated(nulls(GAINS))
    write_thresholds(tmp_path / "thresholds.yaml", measured)
    read = read_thresholds(tmp_path / "thresholds.yaml")
    assert read.named == measured.named
    assert (read.misfit, read.misfit_alone, read.nulls) == (measured.misfit, measured.misfit_alone, 60)
    assert [null.seed for null in measured.nulls] == list(range(60))
    low, high = measured.named_ci95
    assert low < tail_of(GAINS) < high
    assert measured == calibrated(nulls(GAINS))


def test_thresholds_in_force_are_what_the_cases_beside_them_ask_for():
    measured = read_data_file(FILE, Measured, SCHEMA)
    assert len(measured.nulls) == THRESHOLDS.nulls >= 10
    assert THRESHOLDS.named == measured.named >= max(null.worth for null in measured.nulls)
    assert THRESHOLDS.gain == measured.gain >= max(null.gain for null in measured.nulls)
    campaigns = (
        REPOSITORY / "docs" / "campaign" / name for name in ("along", "nulls", "by_gain", "drawn", "uneven_nulls")
    )
    stored = [path for folder in campaigns for path in sorted((folder / "outcomes").glob("*.json"))]
    again = calibrated([Outcome.model_validate_json(path.read_bytes()) for path in stored])
    # The interval takes more resamples than a test does.
    assert replace(again, named_ci95=measured.named_ci95) == measured
    for name, of_null, family in (
        ("misfit", "misfit", norm),
        ("misfit_alone", "misfit_alone", gumbel_r),
    ):
        values = np.array([getattr(null, of_null) for null in measured.nulls])
        assert getattr(THRESHOLDS, name) == getattr(measured, name) >= level_of(values, family)
        assert np.sum(values > getattr(measured, name)) <= 0.05 * len(values)


def test_few_cases_or_one_during_which_the_code_changed_are_refused():
    with pytest.raises(BadInput, match="9 cases with nothing concealed are diagnosed, 10 are needed"):
        calibrated([*nulls(GAINS[:9]), outcome("case_100", "single", ["wind"], "named", ["wind"])])
    changed = [*nulls(GAINS[:20]), *nulls(GAINS[20:])]
    changed[3] = changed[3].model_copy(update={"code_changed": True})
    with pytest.raises(BadInput, match=r"outcomes/case_003\.json: the code changed while it was diagnosed"):
        calibrated(changed)


def test_every_state_of_the_code_that_diagnosed_a_case_is_told():
    assert calibrated([*nulls(GAINS[:20]), *nulls(GAINS[20:], "0ther")]).code_sha256 == ("0ther", "c0de")


def test_a_damaged_file_is_named(tmp_path):
    (tmp_path / "thresholds.yaml").write_text("schema: sim1.thresholds/7\nnamed: many\n")
    with pytest.raises(BadInput, match=r"thresholds\.yaml: .*named is 'many'"):
        read_thresholds(tmp_path / "thresholds.yaml")
