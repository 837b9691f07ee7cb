import numpy as np
import pandas as pd
import pytest

from sim1.policy.equivalence import Worth, by_error, by_success, worth
from sim1.policy.lessons import GENERATED, REAL
from sim1.policy.scaling import PowerLaw, fit_power_law, measure, measure_over_real, measure_tasks


def errors(
    sizes,
    scale=0.4,
    exponent=0.5,
    noise=0.0,
    trajectories=12,
    seeds=3,
    trained_on=GENERATED,
    tested_on=None,
    per_source=1,
):
    """So many trajectories of each held-out demonstration."""
    rng = np.random.default_rng(0)
    return pd.DataFrame(
        {
            "trained_on": trained_on,
            "tested_on": trained_on if tested_on is None else tested_on,
            "size": size,
            "seed": seed,
            "garment": "towel",
            "trajectory": f"{place:04d}",
            "source": f"{place // per_source:04d}",
            "joint_error_rad": scale * size**-exponent * np.exp(noise * rng.normal()) * (1 + 0.05 * place),
            "hold_joint_error_rad": 0.3,
        }
        for size in sizes
        for seed in range(seeds)
        for place in range(trajectories)
    )


NO_TRIALS = pd.DataFrame({"trained_on": [], "size": [], "seed": [], "shift": [], "success": []})


def test_an_exact_power_law_is_found_again():
    fit = fit_power_law(errors([4, 8, 16, 32]), seed=0)
    assert fit.exponent == pytest.approx(0.5, abs=1e-6)
    assert fit.r_squared == pytest.approx(1.0)
    assert fit.at(np.array([8.0])) == pytest.approx(errors([8])["joint_error_rad"].mean())


def test_the_interval_of_the_exponent_holds_the_truth_under_noise():
    fit = fit_power_law(errors([4, 8, 16, 32], noise=0.2), seed=0)
    assert fit.exponent_interval.low < 0.5 < fit.exponent_interval.high
    assert fit.exponent_interval.high - fit.exponent_interval.low < 0.3


def test_two_sizes_are_no_curve():
    assert "at least 3" in fit_power_law(errors([4, 8]), seed=0)


def test_nothing_held_out_is_no_curve_and_no_error():
    empty = errors([4]).iloc[:0]
    assert not isinstance(fit_power_law(empty, seed=0), PowerLaw)
    [point] = measure(empty, NO_TRIALS, {GENERATED: [4]}, seed=0)
    assert point.errors == point.trials == ()
    assert point.all_trials is None


def test_seeds_do_not_narrow_the_interval_as_if_they_were_trajectories():
    few, many = (
        measure(errors([4], seeds=seeds), NO_TRIALS, {GENERATED: [4]}, seed=0)[0].errors[0] for seeds in (1, 50)
    )
    assert many.interval_rad == pytest.approx(few.interval_rad, rel=1e-6)
    assert many.count == 50 * few.count


def networks_apart(spread, rng, seeds=5, trajectories=12):
    """Errors of networks each of which is worse or better as a whole, with a mean of 0.2 among all there could be."""
    of_network = rng.normal(0.2, spread, seeds)
    table = errors([4], seeds=seeds, trajectories=trajectories)
    return table.assign(joint_error_rad=of_network[table["seed"]] + rng.normal(0.0, 0.02, len(table)))


def test_networks_that_differ_widen_the_interval_of_an_error_which_holds_the_mean_of_all_networks():
    rng, held, widths = np.random.default_rng(0), 0, []
    for spread in [0.03] * 60 + [0.0]:
        [point] = measure(networks_apart(spread, rng), NO_TRIALS, {GENERATED: [4]}, seed=0)
        low, high = point.errors[0].interval_rad
        held += spread > 0 and low <= 0.2 <= high
        widths.append(high - low)
    assert held >= 48  # of five networks it is somewhat narrow; it holds 56, one over trajectories alone 21
    assert np.mean(widths[:-1]) > 2 * widths[-1]


def test_a_network_that_was_not_tested_on_a_trajectory_is_an_error_not_a_mean_of_fewer():
    with pytest.raises(ValueError, match=r"no error of the network of seed 2 on \('towel', '0011'\)"):
        measure(errors([4]).iloc[:-1], NO_TRIALS, {GENERATED: [4]}, seed=0)


def test_networks_that_differ_leave_open_what_a_real_demonstration_is_worth():
    rng = np.random.default_rng(1)
    alike, apart = (
        pd.concat(
            [
                rows.assign(joint_error_rad=rows["joint_error_rad"] * np.exp(rng.normal(0, spread, 3))[rows["seed"]])
                for rows in (
                    *(errors([size], tested_on=REAL, noise=0.05) for size in (1, 4, 16)),
                    errors([1], scale=0.2, trained_on=REAL, noise=0.05),
                )
            ]
        )
        for spread in (0.0, 0.2)
    )
    narrow, wide = by_error(alike, seed=0).interval, by_error(apart, seed=0).interval
    assert wide.high - wide.low > 2 * (narrow.high - narrow.low)


def trials(kind, size, wins, of=20, shift="spatial", seed=0):
    """The first placements succeed."""
    return pd.DataFrame(
        {
            "trained_on": kind,
            "size": size,
            "seed": seed,
            "garment": "towel",
            "shift": shift,
            "trial": range(of),
            "success": [number < wins for number in range(of)],
        }
    )


def test_trials_are_counted_by_kind_size_and_shift():
    tried = pd.concat(
        [trials(GENERATED, 4, 1, of=3), trials(GENERATED, 4, 2, of=2, shift="friction"), trials(REAL, 4, 0, of=1)]
    )
    points = measure(errors([4]), tried, {GENERATED: [4], REAL: [4]}, seed=0)
    assert [[(t.shift, t.success_count, t.trial_count) for t in point.trials] for point in points] == [
        [("spatial", 1, 3), ("friction", 2, 2)],
        [("spatial", 0, 1)],
    ]


def networks(kind, size, wins, **others):
    """Trials of a network each, which succeed so often."""
    return pd.concat([trials(kind, size, won, of=10, seed=seed, **others) for seed, won in enumerate(wins)])


def test_networks_that_differ_leave_more_open_than_as_many_trials_of_networks_alike():
    sizes = {GENERATED: [4]}
    alike, apart = (
        measure(errors([4]), networks(GENERATED, 4, wins), sizes, seed=0)[0].trials[0]
        for wins in ((6, 5, 5, 5, 4), (10, 10, 5, 0, 0))
    )
    assert (alike.success_count, alike.trial_count, alike.network_count) == (25, 50, 5)
    assert alike.interval == pytest.approx((0.366, 0.634), abs=1e-3)  # Wilson's of 25 of 50
    assert apart.interval.low < 0.15
    assert apart.interval.high > 0.85
    [task] = measure_tasks(networks(GENERATED, 4, (10, 10, 5, 0, 0), shift="in-domain"))
    assert task.tried.interval == apart.interval


def test_shifts_taken_together_are_no_more_networks_and_of_one_network_no_more_starts():
    both = [
        networks(GENERATED, 4, wins, shift=shift) for shift in ("in-domain", "spatial") for wins in [(9, 9, 5, 1, 1)]
    ]
    [point] = measure(errors([4]), pd.concat(both), {GENERATED: [4]}, seed=0)
    assert (point.all_trials.trial_count, point.all_trials.network_count) == (100, 5)
    assert point.all_trials.interval == pytest.approx(point.trials[0].interval, abs=0.02)
    alone = [trials(GENERATED, 4, 10, shift=shift) for shift in ("in-domain", "spatial")]
    [point] = measure(errors([4]), pd.concat(alone), {GENERATED: [4]}, seed=0)
    assert point.all_trials.interval == pytest.approx(point.trials[0].interval, abs=0.02)  # twenty starts, not forty


def test_generated_and_real_compare_at_the_largest_size_over_trials_from_the_same_placements():
    tried = pd.concat(
        [
            networks(GENERATED, 2, (0, 0)),
            networks(GENERATED, 8, (8, 6)),
            networks(GENERATED, 8, (10, 10), shift="friction"),
            networks(REAL, 4, (4, 2, 9)),
        ]
    )
    found = measure_over_real(tried)
    assert list(found) == ["spatial", "average"]  # with friction the real ones were not tried
    assert (found["spatial"].pair_count, found["spatial"].value) == (20, pytest.approx(0.4))
    assert found["spatial"].interval.low < 0.4 < found["spatial"].interval.high
    assert found["average"] == found["spatial"]
    assert measure_over_real(networks(GENERATED, 8, (8, 6))) == {}


def test_a_real_demonstration_is_worth_the_generated_ones_that_reach_its_error():
    """Generated 0.4 n^-0.5, real 0.2 at n = 1: four generated ones reach 0.2."""
    both = pd.concat(
        [
            errors([1, 4, 16], tested_on=REAL, noise=0.05),
            errors([1], scale=0.2, trained_on=REAL, noise=0.05),
        ]
    )
    found = by_error(both, seed=0)
    assert found.ratio == pytest.approx(4.0, rel=0.3)
    assert found.interval.low < 4.0 < found.interval.high
    assert found.bound is None


def test_beyond_the_sizes_that_were_tried_only_a_bound_is_given():
    both = pd.concat([errors([1, 4, 16], tested_on=REAL), errors([2], scale=0.01, trained_on=REAL)])
    found = by_error(both, seed=0)
    assert (found.bound, found.ratio, found.real_size) == ("more than", 8.0, 2)


@pytest.mark.parametrize(("scale", "bound", "ratio"), [(0.1, "less than", 1.0), (0.4, "more than", 16.0)])
def test_where_more_generated_ones_do_not_help_they_are_as_good_from_the_first_or_never(scale, bound, ratio):
    both = pd.concat(
        [errors([1, 4, 16], scale=scale, exponent=-0.01, tested_on=REAL), errors([1], scale=0.2, trained_on=REAL)]
    )
    found = by_error(both, seed=0)
    assert (found.bound, found.ratio) == (bound, ratio)


@pytest.mark.parametrize("trajectories", [1, 12])
def test_trajectories_of_one_held_out_demonstration_have_no_interval_and_establish_nothing(trajectories):
    kin = {"trajectories": trajectories, "per_source": trajectories}
    [point] = measure(errors([4], **kin), NO_TRIALS, {GENERATED: [4]}, seed=0)
    assert (point.errors[0].interval_rad, point.errors[0].source_count) == (None, 1)
    assert fit_power_law(errors([4, 8, 16], **kin), seed=0).exponent_interval is None
    real = [errors([1, 4, 16], tested_on=REAL, **kin), errors([1], scale=0.2, trained_on=REAL, **kin)]
    assert by_error(pd.concat(real), seed=0).interval is None


def test_a_real_demonstration_is_worth_the_generated_ones_that_succeed_as_often():
    curve = pd.concat([trials(GENERATED, size, wins) for size, wins in ((2, 2), (8, 10), (32, 18))])
    found = by_success(pd.concat([curve, trials(REAL, 2, 10)]), "spatial", seed=0)
    assert found.real_value == 0.5
    assert found.ratio == pytest.approx(4.0, rel=0.1)  # eight generated ones succeed as often as two real ones
    assert found.interval.low < 4.0 < found.interval.high


def test_trials_of_one_network_hang_together_and_those_of_several_are_resampled_network_by_network():
    """One network that nearly always folds and one that nearly never does say less than forty trials of one that folds half the time."""
    wins = {(GENERATED, 2): (0, 6), (GENERATED, 8): (4, 14), (GENERATED, 32): (12, 20), (REAL, 2): (2, 16)}
    both = pd.concat([trials(*kind, some[seed], seed=seed) for kind, some in wins.items() for seed in (0, 1)])
    alone = both.assign(trial=both["trial"] + 20 * both["seed"], seed=0)
    apart, together = by_success(both, "spatial", seed=0), by_success(alone, "spatial", seed=0)
    assert apart.ratio == together.ratio
    assert apart.interval.high - apart.interval.low > together.interval.high - together.interval.low


def test_real_demonstrations_with_the_outcomes_of_as_many_generated_ones_are_worth_these():
    """Also where nearly all trials succeed, and half a trial more of either outcome weighs: log odds of these lie on a line."""
    wins = {8: 1, 16: 10, 32: 19}
    curve = pd.concat([trials(GENERATED, size, won) for size, won in wins.items()])
    for size, won in wins.items():
        twin = by_success(pd.concat([curve, trials(REAL, size, won)]), "spatial", seed=0)
        assert twin.ratio == pytest.approx(1.0, rel=1e-3)


def test_an_interval_that_ends_beyond_the_sizes_that_were_tried_says_so():
    curve = pd.concat([trials(GENERATED, size, wins) for size, wins in ((2, 2), (8, 10), (32, 18))])
    high = by_success(pd.concat([curve, trials(REAL, 2, 18)]), "spatial", seed=0)
    middle = by_success(pd.concat([curve, trials(REAL, 2, 10)]), "spatial", seed=0)
    assert (high.beyond, middle.beyond) == ((False, True), (False, False))


@pytest.mark.parametrize("wins", [0, 20])
def test_none_or_all_is_no_number_to_be_equalled(wins):
    curve = pd.concat([trials(GENERATED, size, 10) for size in (2, 8, 32)])
    assert "is not a number" in by_success(pd.concat([curve, trials(REAL, 2, wins)]), "spatial", seed=0)


def test_numbers_of_trajectories_of_other_garments_do_not_compare():
    lessons = {
        GENERATED: {"splits": [{"garment": "towel"}, {"garment": "polo"}]},
        REAL: {"splits": [{"garment": "towel"}]},
    }
    [said] = worth(lessons, errors([4]), NO_TRIALS, seed=0)
    assert "of towel, generated trajectories of polo, towel" in said
    assert not isinstance(said, Worth)
