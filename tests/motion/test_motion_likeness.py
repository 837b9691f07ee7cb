"""Figures of two sets of ways: how alike they are, and what few demonstrations cannot say."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_paths import arched, some_paths

from sim1.motion.likeness.classifier import told_apart
from sim1.motion.likeness.comparison import Figure, chance, compare, telling
from sim1.motion.likeness.copies import COPY_SHARE, nearest_distances, nearest_of_the_rest
from sim1.motion.likeness.distances import frechet_distance, mmd, standardised
from sim1.motion.likeness.families import FAMILY_MINIMUM, families
from sim1.motion.likeness.features import Movement, shape
from sim1.motion.likeness.limits import LIMITS, in_words, verdicts
from sim1.motion.placement import planar


def test_distances_of_one_distribution_from_itself_are_small_and_of_another_large():
    rng = np.random.default_rng(0)
    one, two = standardised(rng.normal(size=(60, 5)), rng.normal(size=(60, 5)))
    a, b = standardised(rng.normal(size=(60, 5)), rng.normal(1.5, 1, size=(60, 5)))
    assert frechet_distance(one, one) == pytest.approx(0, abs=1e-9)
    assert frechet_distance(one, two) < 0.1 < 0.5 < frechet_distance(a, b)
    own = np.arange(60) % 12
    assert mmd(one, two, own, own, 200, rng).p_value > 0.05
    assert mmd(a, b, own, own, 200, rng).p_value < 0.01
    assert abs(mmd(one, two, own, own, 0, rng).value) < 0.05 < 0.2 < mmd(a, b, own, own, 0, rng).value


def test_movements_that_share_a_source_if_only_over_others_are_one_family():
    made_of = [{"a"}, {"b"}, {"c"}, {"a", "d"}, {"d", "b"}, {"c"}]
    kin = families([frozenset(some) for some in made_of])
    assert kin[0] == kin[1] == kin[3] == kin[4]
    assert kin[2] == kin[5] != kin[0]


def test_movements_alike_within_a_family_do_not_make_a_difference_of_sets():
    """Each set has four near copies of one number a family: twelve numbers against twelve, not 48 against 48."""
    rng = np.random.default_rng(7)
    kin = np.repeat(np.arange(12), 4)
    found = []
    for _ in range(20):
        one, two = (np.repeat(rng.normal(size=(12, 2)), 4, axis=0) + 0.01 * rng.normal(size=(48, 2)) for _ in range(2))
        found.append(mmd(one, two, kin, kin, 100, rng).p_value)
    assert sum(p < 0.05 for p in found) <= 3
    assert np.median(found) > 0.2


def test_the_fewest_families_that_are_compared_can_just_show_a_difference():
    rng = np.random.default_rng(8)
    kin = np.repeat(np.arange(FAMILY_MINIMUM), 4)
    one = rng.normal(size=(len(kin), 2))
    assert mmd(one, one + 5, kin, kin, 500, rng).p_value == pytest.approx(2 / 2**FAMILY_MINIMUM)


def test_a_path_in_both_sets_gives_no_discrepancy_by_itself():
    """Unbiased: pairs within a family, which would be alike, are left out."""
    rng = np.random.default_rng(9)
    kin = np.repeat(np.arange(12), 2)
    values = []
    for _ in range(40):
        one, two = (np.repeat(rng.normal(size=(12, 3)), 2, axis=0) for _ in range(2))
        values.append(mmd(one, two, kin, kin, 0, rng).value)
    assert np.mean(values) == pytest.approx(0, abs=3 * np.std(values) / np.sqrt(40))


def test_the_frechet_distance_of_shifted_sets_is_the_shift_squared():
    sample = np.random.default_rng(1).normal(size=(40, 4))
    assert frechet_distance(sample, sample + np.array([2, 0, 0, 0])) == pytest.approx(2**2 / 4)


def test_equal_distributions_are_not_told_apart_and_shifted_ones_are():
    rng, kin = np.random.default_rng(2), np.arange(80) % 10
    one, two = rng.normal(size=(80, 4)), rng.normal(size=(80, 4))
    alike = told_apart(one, two, kin, kin, rng, 100)
    assert alike.low < 0.5 < alike.high + 0.1
    assert alike.value == pytest.approx(0.5, abs=0.15)
    assert told_apart(one, two + 2, kin, kin, rng, 100).value > 0.97


def test_a_family_is_never_on_both_sides_of_a_fold():
    """What tells real from generated differs from family to family: who has seen none of a family can only guess."""
    rng, kin = np.random.default_rng(3), np.arange(60) % 10
    place, shift = 10 * rng.normal(size=(10, 3)), rng.normal(size=(10, 3))
    one, two = (place[kin] + side * shift[kin] + 1e-3 * rng.normal(size=(60, 3)) for side in (1, -1))
    assert told_apart(one, two, kin, kin, rng, 50).value < 0.75
    alone = np.arange(120)  # nobody is kin: the families are on both sides
    assert told_apart(one, two, alone[:60], alone[60:], rng, 50).value > 0.95


def test_a_copy_is_found_wherever_it_was_put():
    rng = np.random.default_rng(4)
    shown = [Movement(path=arched(rng), order=0, sources=frozenset()) for _ in range(5)]
    shapes = np.stack([shape(item) for item in shown])
    copied = Movement(
        path=shown[2].path.moved(planar(np.array([0.2, 0.1]), 0.5, np.zeros(3))), order=0, sources=frozenset()
    )
    another = Movement(path=arched(rng), order=0, sources=frozenset())
    limit = COPY_SHARE * nearest_of_the_rest(shapes).min()
    copy, other = nearest_distances(np.stack([shape(copied), shape(another)]), shapes)
    assert copy < limit < other


def test_paths_like_the_demonstrations_keep_every_limit_and_shaking_ones_do_not():
    demos, alike, shaking = some_paths(20, 0), some_paths(20, 1), some_paths(20, 2, shake_m=0.004)
    found = {row["figure"]: row["met"] for row in verdicts(compare(demos, alike, 50, np.random.default_rng(0)))}
    assert found == {"join": True, "jerk_share": True, "path_share": True, "auc": True, "copies": True}
    shaken = compare(demos, shaking, 50, np.random.default_rng(0))
    assert {row["figure"] for row in verdicts(shaken) if not row["met"]} >= {"jerk_share", "auc"}
    assert shaken["mmd"].p_value < 0.05


def test_the_most_telling_feature_of_shaking_paths_is_that_they_shake():
    demos, shaking = some_paths(20, 0), some_paths(20, 2, shake_m=0.004)
    first, *_ = telling(demos, shaking, 3)
    assert first["auc"] == 1
    assert first["feature"].split(".")[1] in {"log_jerk", "turned_rad", "sparc", "path_ratio"}
    assert telling(some_paths(3, 0), shaking, 3) == []


def test_copied_demonstrations_are_copies():
    demos = some_paths(20, 0)
    assert compare(demos, demos, 20, np.random.default_rng(0))["copies"].value == 20


def test_what_two_demonstrations_cannot_say_is_not_measured():
    demos = some_paths(1, 0)
    measured = compare(demos, some_paths(3, 1), 20, np.random.default_rng(0))
    assert measured["jerk_share"].value == pytest.approx(1, abs=0.2)
    for name, words in (("auc", "1 transitions, 16 needed"), ("copies", "1 transitions, 2 needed")):
        assert measured[name].value is None
        assert measured[name].record() == {"not_measured": words}
    rows = {row["figure"]: row for row in verdicts(measured)}
    assert rows["auc"]["met"] is None
    assert in_words(rows["auc"]) == "not measured: 1 transitions, 16 needed (limit at most 0.7)"


def test_chance_is_measured_on_the_demonstrations_themselves():
    own = chance(some_paths(40, 0, source_count=20), 2, np.random.default_rng(0))
    assert own["auc"].low <= own["auc"].value <= own["auc"].high
    assert own["auc"].value == pytest.approx(0.5, abs=0.25)
    assert own["jerk_share"].value == pytest.approx(1)
    assert own["nearest"].low > 0


@pytest.mark.parametrize(
    ("count", "sources", "why"),
    [
        (20, 10, "10 transitions in half of the demonstrations, 16 needed"),
        (40, 1, "0 transitions in half of the demonstrations, 16 needed"),
        (40, 2, "1 families of demonstrations and what is made of them in half of the demonstrations, 6 needed"),
        (40, 5, "2 families of demonstrations and what is made of them in half of the demonstrations, 6 needed"),
    ],
)
def test_few_demonstrations_say_nothing_of_chance_however_many_transitions_they_have(count, sources, why):
    own = chance(some_paths(count, 0, source_count=sources), 2, np.random.default_rng(0))
    for name in ("frechet", "mmd", "auc"):
        assert own[name].value is None
        assert own[name].missing == why


@pytest.mark.parametrize("sources", [1, 3, 5])
def test_few_demonstrations_are_no_sets_however_many_paths_are_made_of_them(sources):
    demos, made = some_paths(20, 0, source_count=sources), some_paths(40, 1, source_count=sources)
    found = compare(demos, made, 20, np.random.default_rng(0))
    for name in ("frechet", "mmd", "auc"):
        assert found[name].missing == f"{sources} families of demonstrations and what is made of them, 6 needed"


def test_paths_that_mix_all_demonstrations_make_one_family_of_them():
    demos, made = some_paths(20, 0), some_paths(20, 1)
    everything = frozenset(str(i) for i in range(10))
    mixed = replace(made, movements=[replace(item, sources=everything) for item in made.movements])
    found = compare(demos, mixed, 20, np.random.default_rng(0))
    assert found["auc"].missing == "1 families of demonstrations and what is made of them, 6 needed"


@pytest.mark.parametrize(("value", "met"), [(0.5, False), (0.7, True), (1.0, True), (1.5, True), (1.6, False)])
def test_motion_may_be_neither_rougher_nor_smoother_than_the_demonstrations(value, met):
    limit = next(limit for limit in LIMITS if limit.figure == "jerk_share")
    assert limit.verdict(Figure(value=value))["met"] is met
