import numpy as np
import pandas as pd
import pytest

from sim1.policy.scaling import PowerLaw, fit_power_law, measure


def errors(sizes, scale=0.4, exponent=0.5, noise=0.0, trajectories=12, seeds=3):
    rng = np.random.default_rng(0)
    return pd.DataFrame(
        {
            "size": size,
            "seed": seed,
            "garment": "towel",
            "trajectory": f"{place:04d}",
            "joint_error_rad": scale * size**-exponent * np.exp(noise * rng.normal()) * (1 + 0.05 * place),
            "hold_joint_error_rad": 0.3,
        }
        for size in sizes
        for seed in range(seeds)
        for place in range(trajectories)
    )


NO_TRIALS = pd.DataFrame({"size": [], "seed": [], "success": []})


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
    point = measure(empty, NO_TRIALS, [4], seed=0)[0]
    assert point.joint_error_rad is None
    assert point.trial_count == 0


def test_seeds_do_not_narrow_the_interval_as_if_they_were_trajectories():
    few, many = (measure(errors([4], seeds=seeds), NO_TRIALS, [4], seed=0)[0] for seeds in (1, 50))
    assert many.joint_error_interval_rad == pytest.approx(few.joint_error_interval_rad, rel=1e-6)
    assert many.held_out_count == 50 * few.held_out_count


def test_trials_are_counted_per_size():
    trials = pd.DataFrame({"size": [4, 4, 4, 8], "seed": 0, "success": [True, False, False, True]})
    points = measure(errors([4, 8]), trials, [4, 8], seed=0)
    assert [(point.success_count, point.trial_count) for point in points] == [(1, 3), (1, 1)]
