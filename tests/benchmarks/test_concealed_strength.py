"""An effect is made as strong as its case asks, also where what it does is not proportional to it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.concealed.strength import nearest_to_one

LIMITS = (0.02, 10.0)


def search(share_of, tries=6, usual=1.0):
    """The amplitude that is taken, and all that were tried."""
    tried = []

    def attempt(amplitude):
        tried.append(amplitude)
        return share_of(amplitude), amplitude

    return nearest_to_one(attempt, usual, LIMITS, tries), tried


@given(slope=st.floats(0.15, 30.0), power=st.floats(0.5, 2.0))
def test_a_smooth_answer_is_met_within_its_tolerance(slope, power):
    taken, _ = search(lambda a: slope * a**power, tries=8)
    if LIMITS[0] < slope ** (-1 / power) < LIMITS[1]:
        assert abs(np.log(slope * taken**power)) < np.log(1.4)


def test_a_usual_amplitude_that_does_is_kept():
    assert search(lambda a: 1.1 * a) == (1.0, [1.0])


def test_a_sheet_that_forks_gets_the_amplitude_that_comes_nearest_and_not_the_last_one():
    taken, tried = search(lambda a: 8.0 if a > 0.3 else 0.2 * a)
    assert 0.02 < min(tried) < 0.3 < max(tried)
    shares = [8.0 if a > 0.3 else 0.2 * a for a in tried]
    assert taken == tried[int(np.argmin(np.abs(np.log(shares))))]
    assert len(tried) == 6


@pytest.mark.parametrize(("slope", "end"), [(1e-3, 10.0), (1e3, 0.02)])
def test_what_is_out_of_reach_stops_at_the_end_of_its_range(slope, end):
    taken, tried = search(lambda a: slope * a)
    assert taken == end
    assert tried.count(end) == 1
