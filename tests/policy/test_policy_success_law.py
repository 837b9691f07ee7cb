"""The curve of success over the number of trajectories: form, interval, and why there is none."""

import numpy as np
import pandas as pd
import pytest

from sim1.policy.lessons import GENERATED, REAL
from sim1.policy.success_law import SuccessLaw, fit_success, fit_success_law


def trials(wins, kind=GENERATED, shift="spatial", of=20, networks=1):
    """`wins`: size -> how many of each network's trials succeed."""
    return pd.DataFrame(
        {
            "trained_on": kind, "size": size, "seed": seed, "garment": "towel", "shift": shift, "trial": number,
            "success": number < won,
        }
        for size, won in wins.items()
        for seed in range(networks)
        for number in range(of)
    )  # fmt: skip


def test_more_that_succeed_with_size_are_a_curve_that_passes_through_them():
    law = fit_success_law(trials({2: 2, 8: 10, 32: 18}), seed=0)
    assert (law.size_count, law.network_count, law.trial_count) == (3, 1, 60)
    assert law.at(np.array([2.0, 8.0, 32.0])) == pytest.approx([0.1, 0.5, 0.9], abs=0.03)
    assert law.half_size == pytest.approx(8.0, rel=0.01)
    assert 0 < law.slope_interval.low < law.slope < law.slope_interval.high


def test_where_more_do_not_help_the_interval_of_the_slope_holds_nothing():
    law = fit_success_law(trials({2: 10, 8: 10, 32: 10}), seed=0)
    assert law.slope_interval.low < 0 < law.slope_interval.high


def test_networks_that_differ_leave_more_open_than_as_many_trials_of_one():
    alike = trials({2: 2, 8: 10, 32: 18}, networks=2)
    apart = alike.assign(success=alike["success"] & (alike["seed"] == 0) | (alike["size"] == 32))
    one, two = (fit_success_law(rows, seed=0).slope_interval for rows in (alike, apart))
    assert two.high - two.low > one.high - one.low


def test_all_or_nothing_is_a_curve_with_an_end():
    law = fit_success_law(trials({4: 0, 16: 16, 64: 20}), seed=0)
    assert np.isfinite([law.slope, law.offset, *law.slope_interval]).all()


def test_one_trial_a_size_has_no_interval():
    assert fit_success_law(trials({2: 0, 8: 1, 32: 1}, of=1), seed=0).slope_interval is None


def test_two_sizes_are_no_curve_and_of_which_kind_is_said_once():
    shifts = [trials({4: 1}, kind=REAL, shift=shift) for shift in ("spatial", "in-domain")]
    found = fit_success(pd.concat([trials({2: 2, 8: 10, 32: 18}), *shifts]), seed=0)
    assert [type(one) for one in found] == [SuccessLaw, str]
    assert found[1] == (
        "real demonstrations (stand-in): 1 size was tried in the closed loop; a fitted curve needs at least 3"
    )
    assert fit_success(trials({}).reindex(columns=["trained_on", "shift"]), seed=0) == ["no trial was run"]
