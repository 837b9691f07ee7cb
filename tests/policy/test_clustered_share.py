"""Shares over trials that hang together: how often the intervals hold the truth, and that they agree with published ones."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim1.clustered_share import clustered_interval, counts_by_cluster, effective_count, paired_difference
from sim1.statistics import wilson_interval

NETWORKS, TRIALS, REPEATS = 5, 10, 1000
ROWS = st.lists(st.tuples(st.booleans(), st.booleans(), st.integers(0, 4)), min_size=1, max_size=40)


def beta(rng, mean, likeness, size):
    """Success probabilities of networks; `likeness`: correlation of two trials of one network."""
    total = 1 / likeness - 1
    return rng.beta(mean * total, (1 - mean) * total, size)


@pytest.mark.parametrize(
    ("mean", "likeness", "independent_at_most"),
    [(0.5, 0.1, 0.86), (0.3, 0.3, 0.75), (0.5, 0.3, 0.70), (0.86, 0.3, 0.70)],
)
def test_the_interval_holds_the_truth_about_as_often_as_it_says_where_networks_differ(
    mean, likeness, independent_at_most
):
    """And one that takes all trials as independent does not."""
    rng, held, as_independent = np.random.default_rng(0), 0, 0
    for _ in range(REPEATS):
        won = rng.binomial(TRIALS, beta(rng, mean, likeness, NETWORKS))
        low, high = clustered_interval(won, [TRIALS] * NETWORKS)
        held += low <= mean <= high
        low, high = wilson_interval(int(won.sum()), NETWORKS * TRIALS)
        as_independent += low <= mean <= high
    assert 0.93 <= held / REPEATS <= 0.99
    assert as_independent / REPEATS <= independent_at_most


def test_networks_that_do_not_differ_cost_little():
    rng = np.random.default_rng(1)
    counts = [effective_count(rng.binomial(TRIALS, [0.5] * NETWORKS), [TRIALS] * NETWORKS) for _ in range(REPEATS)]
    assert np.median(counts) > 0.5 * NETWORKS * TRIALS


def test_the_effective_count_is_korn_and_graubards():
    """Shares 0.2, 0.4, 0.6 of ten each: p = 0.4, v = 0.04 / 3; quantiles of t are 2.04523 (29) and 4.30265 (2)."""
    assert effective_count([2, 4, 6], [10, 10, 10]) == pytest.approx(
        0.4 * 0.6 / (0.04 / 3) * (2.04523 / 4.30265) ** 2, rel=1e-5
    )


@pytest.mark.parametrize(
    ("won", "of"),
    [([7], [20]), ([0, 0, 0], [4, 4, 4]), ([4, 4], [4, 4]), ([3, 3], [6, 6]), ([1, 0, 0, 1], [1, 1, 1, 1])],
)
def test_one_network_networks_that_all_did_the_same_and_trials_that_stand_alone_count_in_full(won, of):
    assert effective_count(won, of) == sum(of)
    assert clustered_interval(won, of) == pytest.approx(wilson_interval(sum(won), sum(of)))


def test_nothing_tried_means_nothing_known():
    assert clustered_interval([], []) == (0.0, 1.0)


@given(ROWS)
def test_an_interval_holds_the_share_and_is_never_narrower_than_of_independent_trials(rows):
    wins, _, clusters = map(np.array, zip(*rows, strict=True))
    counts = counts_by_cluster(wins, clusters)
    low, high = clustered_interval(*counts)
    assert 0 <= low <= wins.mean() <= high <= 1
    alone = wilson_interval(int(wins.sum()), len(rows))
    assert high - low >= alone.high - alone.low - 1e-12


def outcomes(both, first, second, neither):
    """Pairs in which so many succeeded, each of a network of its own."""
    numbers = [both, first, second, neither]
    return np.repeat([1, 1, 0, 0], numbers), np.repeat([1, 0, 1, 0], numbers), np.arange(sum(numbers))


@pytest.mark.parametrize(
    ("pairs", "low", "high"),
    [
        # Newcombe, Statistics in Medicine 17 (1998) 2635, table III, method 10.
        ((36, 12, 2, 0), 0.0569, 0.3404),
        ((20, 12, 2, 16), 0.0562, 0.3292),
        ((36, 14, 0, 0), 0.1528, 0.4167),
        ((18, 14, 0, 18), 0.1441, 0.3963),
        ((54, 0, 0, 0), -0.0664, 0.0664),
        ((30, 0, 0, 24), -0.0358, 0.0358),
    ],
)
def test_the_interval_of_a_paired_difference_equals_published_ones(pairs, low, high):
    assert paired_difference(*outcomes(*pairs)).interval == pytest.approx((low, high), abs=5e-5)


@given(ROWS)
def test_a_difference_lies_within_its_interval_which_always_has_a_width(rows):
    found = paired_difference(*map(np.array, zip(*rows, strict=True)))
    assert -1 <= found.interval.low <= found.value + 1e-12
    assert found.value - 1e-12 <= found.interval.high <= 1
    assert found.interval.high - found.interval.low > 0.01


def test_the_interval_of_a_paired_difference_holds_the_truth_about_as_often_as_it_says():
    """Networks of two arms that differ, and placements that are hard for both."""
    rng, held, count = np.random.default_rng(2), 0, 600
    labels = np.repeat(np.arange(NETWORKS), TRIALS)
    for _ in range(count):
        hard = rng.random((NETWORKS, TRIALS)) < 0.3
        sides = [
            (~hard & (rng.random(hard.shape) < beta(rng, mean, 0.2, (NETWORKS, 1)))).ravel() for mean in (0.8, 0.5)
        ]
        interval = paired_difference(*sides, labels).interval
        held += interval.low <= 0.7 * 0.3 <= interval.high
    assert 0.93 <= held / count <= 0.995
