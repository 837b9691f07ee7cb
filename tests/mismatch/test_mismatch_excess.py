"""How much of what a baseline leaves over noise and mesh a model explains."""

from dataclasses import replace

import numpy as np
import pytest
from small_pool import fitted

from sim1.mismatch.excess import explained, left, mean_square
from sim1.mismatch.thresholds import THRESHOLDS


def test_a_recording_in_which_an_effect_does_nothing_is_no_witness_against_it(unknowns):
    """A sheet that wrinkles in shear is wrong with and without it."""
    null, better = fitted(unknowns, pulled=2.0, wrinkled=4.0), fitted(unknowns, pulled=1.2, wrinkled=4.0)
    assert explained(null, better, THRESHOLDS) == pytest.approx(0.8)
    assert mean_square(null) - mean_square(better) < THRESHOLDS.explained * (mean_square(null) - 1.0)


def test_fitting_better_what_fitted_already_explains_no_excess_elsewhere(unknowns):
    """A magnet: a tilt helps where there was no excess, and what the magnet does is left as it was."""
    null, better = fitted(unknowns, easy=0.95, pushed=1.75), fitted(unknowns, easy=0.85, pushed=1.75)
    assert explained(null, better, THRESHOLDS) == 0.0


def test_what_is_left_counts_where_a_name_gains(unknowns):
    """A magnet pushes in one swing; that four other recordings have no excess does not make a tilt explain that one."""
    quiet = {f"quiet_{k}": 0.8 for k in range(4)}
    null, tilt = fitted(unknowns, pushed=1.6, **quiet), fitted(unknowns, pushed=1.47, **quiet)
    assert mean_square(tilt) < THRESHOLDS.left
    assert left(null, tilt) == pytest.approx(1.47)
    assert explained(null, tilt, THRESHOLDS) < THRESHOLDS.explained


def test_what_explains_most_of_all_that_is_left_need_not_explain_half_of_it_where_it_gains_most(unknowns):
    """A tilted frame: what it takes off three swings is most of the excess; in a fourth, where two simulators differ, it gains more."""
    null = fitted(unknowns, one=1.5, two=1.5, three=1.5, crumpled=1.8)
    tilt = fitted(unknowns, one=1.02, two=1.02, three=1.02, crumpled=1.5)
    for fit, temper in ((null, 8.0), (tilt, 8.0)):
        fit.temper.update(one=temper, two=temper, three=temper)  # which witness less
    assert explained(null, tilt, THRESHOLDS) == pytest.approx(1 - 0.56 / 2.3)
    assert left(null, tilt) > THRESHOLDS.left


def test_what_a_baseline_had_to_leave_its_priors_for_is_explained(unknowns):
    """A baseline whose lengths are 20 deviations off fits a shrunk sheet as well as shrinkage does."""
    null = replace(fitted(unknowns, pulled=1.25), z=np.array([20.0, 12.0]))
    shrunk = replace(fitted(unknowns, pulled=1.24), z=np.array([1.0, 0.7]))
    assert explained(null, shrunk, THRESHOLDS) > 0.9


def test_what_a_model_explains_shows_where_the_baseline_misses_by_far(unknowns):
    """With a fixed cap on gross errors, both would count the same."""
    null, better = fitted(unknowns, thrown=300.0), fitted(unknowns, thrown=40.0)
    assert mean_square(null) == mean_square(better) == 25.0
    assert explained(null, better, THRESHOLDS) == pytest.approx(260 / 299)
