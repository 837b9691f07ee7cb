"""Success in every shift, and what a shift changes, pair by pair."""

import pandas as pd
import pytest

from sim1.policy.image_trials.measures import by_shift, measure, of_all
from sim1.policy.image_trials.page import result_section
from sim1.statistics import wilson_interval


def row(garment, shift, number, won):
    """A trial of one network."""
    failure = None if won else "slip"
    return {"garment": garment, "seed": 0, "shift": shift, "trial": number, "success": won, "failure": failure}


def test_a_change_is_counted_pair_by_pair():
    wins = {"in-domain": [1, 1, 0, 0], "lighting": [1, 0, 0, 0], "viewpoint": [0, 0, 1, 0]}
    rows = [
        row("towel", shift, number, bool(won)) for shift, all_of in wins.items() for number, won in enumerate(all_of)
    ]
    tried = {one.shift: one for one in measure(pd.DataFrame(rows))}
    assert tried["in-domain"].change is None
    assert tried["lighting"].change.value == -0.25
    assert tried["viewpoint"].change.value == -0.25
    assert tried["lighting"].change.interval.high > 0
    assert tried["viewpoint"].change.interval.high > tried["lighting"].change.interval.high  # its pairs disagree
    assert tried["viewpoint"].failures == {"slip": 3}
    alone = [row for row in rows if row["shift"] == "lighting"]
    assert measure(pd.DataFrame(alone))[0].change is None


@pytest.mark.parametrize(("before", "after", "value"), [(0, 0, 0.0), (1, 1, 0.0), (1, 0, -1.0), (0, 1, 1.0)])
def test_pairs_that_all_agree_or_all_differ_leave_open_what_others_would_do(before, after, value):
    rows = [
        row("towel", shift, number, bool(won))
        for shift, won in (("in-domain", before), ("lighting", after))
        for number in (0, 1)
    ]
    change = {one.shift: one for one in measure(pd.DataFrame(rows))}["lighting"].change
    assert (change.pair_count, change.value) == (2, value)
    assert change.interval.high - change.interval.low > 0.5
    assert change.interval.low <= value <= change.interval.high


def test_all_shifts_together_begin_in_no_more_placements_than_one():
    """Trials of a number succeed in every shift or in none: eight of them say as much as one shift's, not as 32 would."""
    shifts = ("in-domain", "texture", "lighting", "viewpoint")
    rows = [row("towel", shift, number, number < 4) for shift in shifts for number in range(8)]
    tried = measure(pd.DataFrame(rows))
    every = of_all(tried)
    assert (every.success_count, every.trial_count, every.network_count) == (16, 32, 1)
    assert every.interval == pytest.approx(wilson_interval(4, 8), abs=0.06)
    assert len(by_shift(tried)) == 4


def test_several_garments_are_counted_together_and_each_by_itself():
    rows = [
        row(garment, "in-domain", number, garment == "towel") for garment in ("towel", "polo") for number in range(3)
    ]
    tried = measure(pd.DataFrame(rows))
    assert [(one.garment, one.success_count, one.trial_count) for one in tried] == [
        (None, 3, 6),
        ("towel", 3, 3),
        ("polo", 0, 3),
        (None, 3, 6),
    ]
    assert by_shift(tried) == tried[:1]
    assert of_all(tried) == tried[-1]


@pytest.mark.parametrize(("networks", "alone"), [(1, True), (3, False)])
def test_the_page_says_of_one_network_what_its_intervals_do_not_hold(tmp_path, networks, alone):
    rows = [
        {**row("towel", "in-domain", number, number < 2), "seed": seed}
        for seed in range(networks)
        for number in range(3)
    ]
    about = {
        "title": "A very small ACT", "type": "act", "size": "tiny", "steps": 1, "train_count": 4, "worlds": ["stand-in reality"],
        "garments": ["towel"], "network_seeds": list(range(networks)),
    }  # fmt: skip
    said = " ".join(result_section("Result", tmp_path, measure(pd.DataFrame(rows)), about).paragraphs)
    assert f"drives ({'one network' if alone else '3 networks'}) in the stand-in reality" in said
    assert ("One network alone drove everywhere here; such an interval is that of its trials" in said) is alone
