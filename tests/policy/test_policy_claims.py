"""What the paper claims, beside what a run measured: each verdict follows from counts and intervals, and none from a robot."""

import math

import pandas as pd
import pytest

from sim1.clustered_share import Difference
from sim1.policy import paper
from sim1.policy.claims.evidence import Evidence
from sim1.policy.claims.page import HEADING, NODES, Plans, claims_section
from sim1.policy.claims.table import CLAIMS
from sim1.policy.claims.verdict import (
    AGREES,
    DISAGREES,
    NOT_DECIDED,
    NOT_RUN,
    Measured,
    Missing,
    about,
    more_than_nothing,
    success_of,
    verdict,
)
from sim1.policy.curve import Curve
from sim1.policy.equivalence import Worth
from sim1.policy.image_trials.measures import measure
from sim1.policy.lessons import GENERATED
from sim1.policy.results_page import results
from sim1.policy.scaling import Point
from sim1.policy.success_law import SuccessLaw
from sim1.policy.tried import Tried
from sim1.statistics import Interval, wilson_interval


def claim(words):
    [found] = [one for one in CLAIMS if words in one.text]
    return found


def said(words, known):
    found = claim(words)
    return verdict(found.find(known), found.band)


def measured(low, high):
    return Measured(shown="", interval=Interval(low, high))


@pytest.mark.parametrize(
    ("found", "word"),
    [
        (measured(0.1, 0.4), AGREES),
        (measured(-0.4, -0.1), DISAGREES),
        (measured(-0.1, 0.4), NOT_DECIDED),
        (measured(0.0, 0.4), NOT_DECIDED),  # an interval that begins at nothing holds it
        (measured(-0.4, 0.0), DISAGREES),
        (Measured(shown="one trial", interval=None), NOT_DECIDED),
        (Missing(why="no trial"), NOT_RUN),
    ],
)
def test_an_interval_inside_agrees_outside_disagrees_across_decides_nothing(found, word):
    assert verdict(found, more_than_nothing()) == word


def test_what_agrees_is_as_wide_as_the_papers_own_trials_leave_open():
    assert success_of(67, 30).low == pytest.approx(wilson_interval(20, 30).low)
    assert "49 %" in success_of(67, 30).words
    assert (about(15, 2.0).low, about(15, 2.0).high) == (7.5, 30)


def tried(shift, won, of=50):
    return Tried(shift=shift, trial_count=of, success_count=won, network_count=5, interval=wilson_interval(won, of))


def curve(*trials, worths=(), over_real=None, laws=()):
    every = tried(paper.AVERAGE, sum(one.success_count for one in trials), sum(one.trial_count for one in trials))
    point = Point(trained_on=GENERATED, size=64, seed_count=5, errors=(), trials=trials, all_trials=every)
    return Curve(
        points=(point,), fits=(), success_fits=laws, worths=worths, tasks=(), over_real=over_real or {}, worlds={}
    )


def worth(ratio, low, high, beyond=(False, False), bound=None):
    return Worth(
        figure="success, in-domain", shift="in-domain", real_size=16, real_value=0.8, ratio=ratio, bound=bound,
        interval=Interval(low, high), beyond=beyond,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("found", "word"),
    [
        (worth(14.0, 9.0, 20.0), AGREES),
        (worth(1.0, 0.7, 1.6), DISAGREES),
        (worth(9.0, 3.0, 20.0), NOT_DECIDED),
        (
            worth(4.0, 3.9, 4.0, beyond=(False, True), bound="more than"),
            NOT_DECIDED,
        ),  # the end is a bound: it may be 15
        ("success, in-domain: 2 sizes of generated trajectories were tested; a curve needs at least 3", NOT_DECIDED),
    ],
)
def test_the_worth_of_a_real_demonstration_is_decided_by_its_interval(found, word):
    known = Evidence(curve=curve(tried("in-domain", 40), worths=(found,)))
    assert said("15 generated trajectories, in-domain", known) == word


def test_the_worth_in_a_shift_that_was_not_tried_was_not_run():
    assert said("5 generated trajectories, texture", Evidence(curve=curve(tried("in-domain", 40)))) == NOT_RUN


@pytest.mark.parametrize(("won", "word"), [(50, AGREES), (6, DISAGREES), (29, NOT_DECIDED)])
def test_success_with_a_state_policy_is_held_against_what_the_papers_trials_leave_open(won, word):
    assert said("Policy that knows the keypoints, in-domain", Evidence(curve=curve(tried("in-domain", won)))) == word


def image(*counts):
    rows = [
        {"garment": "towel", "seed": 0, "trial": number, "shift": shift, "success": number < won, "failure": None}
        for shift, won in counts
        for number in range(50)
    ]
    return measure(pd.DataFrame(rows))


def test_success_with_pictures_has_a_verdict_for_each_shift_and_an_average_only_of_all_of_them():
    known = Evidence(
        image=image(("in-domain", 47), ("spatial", 6), ("texture", 2), ("lighting", 35), ("viewpoint", 29))
    )
    verdicts = {shift: said(f"alone, {shift}:", known) for shift in paper.SHIFTS}
    assert verdicts == {
        "in-domain": AGREES, "spatial": DISAGREES, "texture": DISAGREES, "lighting": NOT_DECIDED, "viewpoint": AGREES,
    }  # fmt: skip
    assert said("(ablation table; policy", known) == DISAGREES
    assert said("(ablation table; policy", Evidence(image=image(("in-domain", 50)))) == NOT_RUN


@pytest.mark.parametrize(
    ("interval", "word"), [((0.31, 0.72), AGREES), ((-0.4, -0.1), DISAGREES), ((-0.1, 0.3), NOT_DECIDED)]
)
def test_generated_against_real_is_decided_by_the_difference_over_pairs(interval, word):
    over = {"spatial": Difference(pair_count=50, value=sum(interval) / 2, interval=Interval(*interval))}
    known = Evidence(curve=curve(tried("spatial", 26), over_real=over))
    assert said("more than real demonstrations, spatial", known) == word
    assert said("more than real demonstrations, lighting", known) == NOT_RUN


@pytest.mark.parametrize(
    ("interval", "word"), [((0.5, 2.0), AGREES), ((-0.5, 2.0), NOT_DECIDED), ((-2.0, -0.5), DISAGREES)]
)
def test_whether_success_rises_is_decided_by_the_slope_of_its_curve(interval, word):
    law = SuccessLaw(
        trained_on=GENERATED, shift="in-domain", size_count=3, network_count=5, trial_count=150, offset=0.0,
        slope=sum(interval) / 2, slope_interval=Interval(*interval), half_size=None,
    )  # fmt: skip
    assert said("Success rises", Evidence(curve=curve(tried("in-domain", 40), laws=(law,)))) == word
    assert said("Success rises", Evidence(curve=curve(tried("in-domain", 40), laws=("none",)))) == NOT_RUN


def row(accepted, of, trials=None, over_base=None):
    won = trials and {"success_count": trials[0], "trial_count": trials[1], "interval": wilson_interval(*trials)}
    return {
        "accepted_count": accepted, "candidate_count": of, "all_trials": won, "over_base": over_base,
        "shifts": [{"shift": "spatial"}],
    }  # fmt: skip


def test_rows_of_the_ablation_are_decided_by_their_counts():
    known = Evidence(
        ablation={
            "slicing": row(0, 500),
            "decomposition": row(39, 82),
            "diffusion": row(45, 100),
            "calibrated": row(400, 1000),
        }
    )
    assert said("Ablation, Baseline", known) == AGREES
    assert said("Ablation, + trajectory decomposition: 65", known) == NOT_DECIDED
    assert said("Ablation, + diffusion-based generation: 38", known) == NOT_DECIDED
    assert said("Ablation, + deformation-stable solver: 40", known) == AGREES
    assert said("Ablation, + diffusion-based generation: its policy", known) == NOT_RUN
    assert said("more often than slicing", known) == AGREES
    sliced = Evidence(ablation={"slicing": row(39, 82), "calibrated": row(32, 72)})
    assert said("Ablation, Baseline", sliced) == DISAGREES
    assert said("more often than slicing", sliced) == NOT_DECIDED
    assert said("more often than slicing", Evidence(ablation={"calibrated": row(32, 72)})) == NOT_RUN


@pytest.mark.parametrize(("won", "word"), [(20, AGREES), (45, NOT_DECIDED), (80, DISAGREES)])
def test_whether_alignment_decides_is_what_calibration_is_ahead_of_the_data_sheet(won, word):
    known = Evidence(ablation={"calibrated": row(1, 2, trials=(50, 100)), "uncalibrated": row(1, 2, trials=(won, 100))})
    assert said("a calibrated simulator teaches more", known) == word


@pytest.mark.parametrize(
    ("interval", "word"), [((-0.4, -0.1), AGREES), ((-0.2, 0.1), NOT_DECIDED), ((0.1, 0.4), DISAGREES)]
)
def test_whether_naming_decides_is_what_the_base_is_ahead_of_calibration_alone(interval, word):
    over = {"pair_count": 50, "value": sum(interval) / 2, "interval": list(interval)}
    known = Evidence(ablation={"calibrated": row(30, 72, trials=(20, 50), over_base=over)})
    assert said("the physics that was named teaches more", known) == word


def test_whether_the_solver_decides_is_the_difference_of_two_policies():
    known = Evidence(ablation={"calibrated": row(1, 2, trials=(76, 100)), "diffusion": row(1, 2, trials=(33, 100))})
    assert said("the deformation-stable solver adds 43 points", known) == AGREES


def costs(seconds):
    """This machine at $0.10 an hour, 40 of 100 attempts accepted."""
    day = 86400 / seconds
    real = {"usd_per_day": 282.19, "measured": False}
    server = {"usd_per_day": 71.04, "measured": False}
    here = {"usd_per_day": 2.4, "trajectories_per_day": day, "usd_per_trajectory": 2.4 / day, "measured": True}
    pace = {"attempted_s": 0.2 * seconds, "accepted_s": 0.5 * seconds, "shown_s": 0.5 * seconds, "frames_share": 0.4}
    return {"methods": [real, server, here], "pace": pace, "attempted_count": 100, "accepted_count": 40}


@pytest.mark.parametrize(
    ("seconds", "full", "word"),
    [(60, True, AGREES), (60, False, NOT_DECIDED), (60_000, True, DISAGREES), (60_000, False, DISAGREES)],
)
def test_small_pictures_make_a_cost_a_bound_that_can_refute_a_claim_and_never_confirm_it(seconds, full, word):
    known = Evidence(costs=costs(seconds), full_frames=full)
    assert said("A generated trajectory costs", known) == word
    assert said("trajectories a day", known) == word
    assert said("A day of real collection", known) == said("A day of simulation", known) == AGREES


def test_a_claim_that_was_not_run_says_which_profile_runs_it():
    settings = {
        "quick": {"policy": {"shifts": ["in-domain"], "trial_count": 1}},
        "paper": {"policy": {"shifts": ["in-domain", "friction"], "trial_count": 30}, "slicing/valid_trajectories": {}},
    }
    section = claims_section({}, Plans(profile="quick", settings=settings))
    assert section.heading == HEADING
    assert {row["Verdict"] for row in section.table} == {NOT_RUN}
    why = {row["Claim of the paper"]: row["Why"] for row in section.table}
    assert (
        "Measured by profile paper: `sim1 run --profile paper --select scaling_report`."
        in why[claim("Policy that knows the keypoints, texture").text]
    )
    assert (
        "`sim1 run --select scaling_report` in this profile (quick)"
        in why[claim("Policy that knows the keypoints, in-domain").text]
    )
    assert "No profile makes diffusion/policy." in why[claim("diffusion-based generation: its policy").text]
    assert "Measured by profile paper" in why[claim("Ablation, Baseline").text]


def test_every_claim_stands_on_the_page_of_results_before_all_else_with_what_a_report_that_cannot_be_read_says(
    tmp_path,
):
    section = results({"scaling_report": {"": tmp_path}}, {"scaling_report": "it is stale"})[0]
    assert [row["Claim of the paper"] for row in section.table] == [one.text for one in CLAIMS]
    assert len({one.text for one in CLAIMS}) == len(CLAIMS)
    assert "curve.json" in section.table[0]["Why"]
    assert "it is stale" in section.paragraphs[-1]
    assert "No verdict is about a robot" in section.paragraphs[1]


def test_claims_ask_for_nodes_that_some_profile_may_have():
    assert {"policy", "image_trials", "slicing/valid_trajectories", "uncalibrated/policy"} <= set(NODES)
    assert all(math.isfinite(one.band.low) or math.isfinite(one.band.high) for one in CLAIMS)


def test_a_profile_that_cannot_be_read_is_told():
    section = claims_section(
        {}, Plans(profile="quick", damaged={"study": "pipeline/profiles/study.yaml: no such stage"})
    )
    told = (
        "Profile study cannot be read, what it would measure is not told: pipeline/profiles/study.yaml: no such stage."
    )
    assert told in section.paragraphs
