import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim1.statistics import Interval, describe_share, difference_interval, wilson_interval


@pytest.mark.parametrize(
    ("successes", "trials", "low", "high"),
    [
        # Newcombe, Statistics in Medicine 17 (1998) 857, table I, method 3 (score without continuity correction).
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_wilson_interval_equals_published_values(successes, trials, low, high):
    assert wilson_interval(successes, trials) == pytest.approx((low, high), abs=5e-5)


@given(st.integers(1, 500).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_wilson_interval_holds_the_share_and_mirrors(counts):
    successes, trials = counts
    low, high = wilson_interval(successes, trials)
    assert 0 <= low <= successes / trials <= high <= 1
    mirrored = wilson_interval(trials - successes, trials)
    assert (1 - mirrored.high, 1 - mirrored.low) == pytest.approx((low, high), abs=1e-12)


def test_nothing_tried_means_nothing_known():
    assert wilson_interval(0, 0) == (0.0, 1.0)
    assert describe_share(0, 0) == "none tried"


@pytest.mark.parametrize("counts", [(-1, 3), (4, 3)])
def test_impossible_counts_are_refused(counts):
    with pytest.raises(ValueError, match="between 0 and trial_count"):
        wilson_interval(*counts)


def test_share_is_described_with_counts_and_interval():
    assert describe_share(3, 10) == "3 of 10 = 30 % (95 % interval 11 to 60 %)"


def test_the_interval_of_a_difference_is_newcombes():
    """Table II of his paper, 56 of 70 minus 48 of 80 by method 10."""
    sides = [(won / of, wilson_interval(won, of)) for won, of in ((56, 70), (48, 80))]
    assert difference_interval(*sides) == pytest.approx((0.0524, 0.3339), abs=1e-4)
    assert difference_interval((1.0, wilson_interval(10, 10)), (0.0, wilson_interval(0, 10))).high == 1.0


def test_shares_that_rise_and_fall_together_differ_less():
    sides = [(won / of, wilson_interval(won, of)) for won, of in ((56, 70), (48, 70))]
    apart, together = difference_interval(*sides), difference_interval(*sides, correlation=0.5)
    assert apart.low < together.low < together.high < apart.high


def test_a_share_with_an_interval_of_its_own_is_described_with_that():
    assert describe_share(3, 10, Interval(0.01, 0.9)) == "3 of 10 = 30 % (95 % interval 1 to 90 %)"
