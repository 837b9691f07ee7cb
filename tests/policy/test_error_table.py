"""Intervals of errors on trajectories that hang together, as those of one held-out demonstration do."""

import numpy as np
import pandas as pd
import pytest
from made_up_dataset import toy_trajectory

from sim1.policy.error_table import ErrorTable, error_table, interval_of, said_of_errors
from sim1.policy.split import sources_of_tests, split_by_garment


def drawn(sizes, between, rng, networks=1):
    """Errors about 1, of so many trajectories of each demonstration; a share of their variance is between these."""
    sources = np.repeat(np.arange(len(sizes)), sizes)
    of_source, own = rng.normal(size=len(sizes)), rng.normal(size=len(sources))
    errors = 1.0 + 0.1 * (np.sqrt(between) * of_source[sources] + np.sqrt(1 - between) * own)
    return ErrorTable(errors=np.repeat(errors[:, None], networks, axis=1), sources=sources)


@pytest.mark.parametrize(
    ("sizes", "between"),
    [((4,) * 6, 0.3), ((4,) * 6, 0.0), ((14, 9), 0.3), ((12, 12), 0.6), ((10, 1, 6, 3, 2, 8), 0.3)],
)
def test_intervals_hold_the_mean_of_all_demonstrations_as_often_as_they_say(sizes, between):
    """Drawn one by one, as if no two trajectories were kin, they hold it in 40 to 94 % of the cases."""
    rng = np.random.default_rng(0)
    held = [
        low <= 1.0 <= high
        for low, high in (interval_of(drawn(sizes, between, rng), rng, least=0.0) for _ in range(400))
    ]
    assert 0.9 <= np.mean(held) <= 0.98


def test_of_as_many_trajectories_each_it_is_students_interval_of_the_means_of_demonstrations():
    table = drawn((3,) * 5, 0.5, np.random.default_rng(2))
    means = table.errors.reshape(5, 3).mean(axis=1)
    half = 2.776 * means.std(ddof=1) / np.sqrt(5)  # Student's quantile for 4 degrees of freedom
    found = interval_of(table, np.random.default_rng(0))
    assert found == pytest.approx((means.mean() - half, means.mean() + half), rel=0.02)


def test_an_error_is_nowhere_less_than_nothing_and_a_change_may_be():
    table = ErrorTable(errors=np.array([[0.1], [0.2]]), sources=np.arange(2))
    assert interval_of(table, np.random.default_rng(0), least=0.0).low == 0.0
    assert interval_of(table, np.random.default_rng(0)).low < 0.0


def test_demonstrations_of_one_name_are_others_where_the_garment_is():
    rows = [
        {"garment": garment, "source": "0003", "trajectory": name, "seed": 0, "joint_error_rad": 0.1}
        for garment in ("polo", "towel")
        for name in ("0000", "0001")
    ]
    table = error_table(pd.DataFrame(rows))
    assert table.source_count == 2
    assert table.sources.tolist() == [0, 0, 1, 1]


def test_held_out_trajectories_are_told_by_the_held_out_demonstrations_that_they_come_from():
    """Eight of four demonstrations; what else a trajectory uses may be in training too, and is no reason to be kin."""
    uses = [{"a"}, {"b"}, {"c", "b"}, {"d"}, {"d", "b"}, {"b"}, {"a", "b"}, {"b"}]
    items = [toy_trajectory("towel", f"{place:04d}", own, seed=place) for place, own in enumerate(uses)]
    splits = split_by_garment(items, test_share=0.4, seed=0)
    assert set(splits["towel"].held_out_sources) < set("acd")
    found = sources_of_tests(splits)
    assert set(found) == {("towel", item.name) for item in splits["towel"].test}
    assert {frozenset({source}) for source in found.values()} == {
        items[int(name)].sources & set(splits["towel"].held_out_sources) for _, name in found
    }


def test_trajectories_that_link_two_held_out_demonstrations_make_them_one():
    uses = [{"a"}, {"b"}, {"a", "b"}, {"c"}, {"d"}, {"e"}, {"f"}]
    items = [toy_trajectory("towel", f"{place:04d}", own, seed=place) for place, own in enumerate(uses)]
    [split] = split_by_garment(items, test_share=0.42, seed=0).values()
    assert split.held_out_sources == ("a", "b")
    assert set(split.sources_of_tests().values()) == {"a + b"}


def test_where_no_demonstration_could_be_held_out_trajectories_that_share_one_hang_together():
    uses = [{"a", "b"}] * 4
    items = [toy_trajectory("towel", f"{place:04d}", own, seed=place) for place, own in enumerate(uses)]
    [split] = split_by_garment(items, test_share=0.5, seed=0).values()
    assert (split.kind, len(split.test)) == ("trajectory", 2)
    assert set(split.sources_of_tests().values()) == {"a + b"}


def test_it_is_said_why_an_error_has_no_interval():
    assert "alone has no interval" not in said_of_errors({"generated": 2, "real": 6})
    assert "is not known: here: real." in said_of_errors({"generated": 2, "real": 1})
    assert "is not known: everywhere here." in said_of_errors({"generated": 1})
