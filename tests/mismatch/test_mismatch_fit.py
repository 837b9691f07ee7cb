"""Gauss-Newton with priors on a model whose answer is known."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle, filmed, plain_world
from straight_engine import TRUE, Straight, two_unknowns

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import LEAST_CURVATURE, curvatures, fit, loss, promised, secant_weights, weights
from sim1.mismatch.patience import Patience
from sim1.stage import BadInput


@pytest.fixture
def unknowns():
    return two_unknowns()


def test_a_straight_model_is_fitted_within_its_own_interval(unknowns):
    found = fit(Straight(), unknowns, np.zeros(2), ("only",), temper={"only": 1.0})
    assert found.converged
    off = found.z - TRUE
    assert off @ np.linalg.solve(found.covariance, off) < 9.2  # chi-square of two, 99 %


def test_a_step_is_tried_with_its_slopes_and_the_search_ends_with_those_of_its_end(unknowns):
    engine = Straight(bent=0.3)
    found = fit(engine, unknowns, np.zeros(2), ("only",), temper={"only": 1.0}, most=20)
    measured = engine.slopes(unknowns, found.z, ("only",))[1]["only"]
    assert found.converged
    assert found.slopes["only"] == pytest.approx(measured)
    assert promised(found) < 0.5
    assert engine.looks <= 6  # the start, a few steps, and the test's own


def test_curvatures_are_second_derivatives_of_the_loss_where_it_bends_up():
    residual, step = np.array([0.0, 0.5, -1.1]), 1e-4
    measured = (loss(residual + step) - 2.0 * loss(residual) + loss(residual - step)) / step**2
    np.testing.assert_allclose(curvatures(residual), measured, rtol=1e-5)
    far = np.array([3.0, -30.0])
    np.testing.assert_allclose(curvatures(far), LEAST_CURVATURE * weights(far))


def test_slopes_that_somebody_guessed_are_not_believed_at_the_end(unknowns):
    engine = Straight(bent=0.3)
    residuals, slopes = engine.slopes(unknowns, np.zeros(2), ("only",))
    wrong = {"only": slopes["only"][:, ::-1]}
    found = fit(
        engine, unknowns, np.zeros(2), ("only",), temper={"only": 1.0}, given=(residuals, wrong), exact=False, most=20
    )
    straight = fit(engine, unknowns, np.zeros(2), ("only",), temper={"only": 1.0}, most=20)
    assert found.converged
    assert found.cost == pytest.approx(straight.cost, abs=0.5)


def test_secant_weights_are_those_by_which_the_likelihood_gains_exactly_the_difference_of_squares():
    rng = np.random.default_rng(0)
    before = np.concatenate([rng.normal(size=50), 30.0 * rng.normal(size=50), [0.0, 1.0, 1.0, 1.0, -1.0]])
    after = np.concatenate([rng.normal(size=100), [2.0, 1.0, 1.0 + 1e-9, 1.0 + 1e-4, 1.0]])
    gained = secant_weights(before, after) * (before**2 - after**2) / 2
    np.testing.assert_allclose(gained, loss(before) - loss(after), rtol=1e-9, atol=1e-14)


def test_a_sample_that_counts_a_fourth_doubles_the_deviation(unknowns):
    once, fourth = (fit(Straight(), unknowns, np.zeros(2), ("only",), temper={"only": temper}) for temper in (1.0, 4.0))
    ratio = np.sqrt(np.diag(fourth.covariance) / np.diag(once.covariance))
    assert ratio == pytest.approx(2.0, rel=0.02)


def test_a_search_that_no_simulation_follows_is_not_called_converged(unknowns):
    found = fit(Straight(border=1e-3), unknowns, np.zeros(2), ("only",), temper={"only": 1.0})
    assert not found.converged
    assert found.z == pytest.approx(np.zeros(2))


def test_a_search_whose_slopes_cannot_be_measured_anew_keeps_what_it_found_and_is_not_called_converged(unknowns):
    found = fit(Straight(bent=0.3, most_looks=1), unknowns, np.zeros(2), ("only",), temper={"only": 1.0})
    assert not found.converged
    assert np.linalg.norm(found.z - TRUE) < 0.5 * np.linalg.norm(TRUE)


def test_a_search_that_was_stopped_is_not_called_converged(unknowns):
    stopped = Patience()
    stopped.interrupt()
    assert not fit(Straight(patience=stopped), unknowns, np.zeros(2), ("only",), temper={"only": 1.0}).converged


def test_a_search_aside_leaves_the_mesh_and_its_errors_as_they_were_even_where_it_finds_no_way():
    with Engine(filmed(empty_bundle(motions=2))) as engine:
        engine.refine(plain_world(engine.bundle), engine.names)
        known = [(engine.observed(name).mesh_m, engine.stages[name].rest_m) for name in engine.names]
        before = engine.finer, engine.follow_hz

        def lost():
            with engine.aside():
                engine.finer, engine.follow_hz = 0, 0.5
                engine.refine(replace(plain_world(engine.bundle), stretch_n_m=50.0), engine.names)
                raise NotConverged("no way")

        with pytest.raises(NotConverged):
            lost()
        assert (engine.finer, engine.follow_hz) == before
        for name, kept in zip(engine.names, known, strict=True):
            assert (engine.observed(name).mesh_m, engine.stages[name].rest_m) == kept


def test_noise_that_is_neither_stated_nor_measurable_is_asked_for():
    bundle = empty_bundle(motions=2)
    moving = tuple(replace(r, starts="moving") for r in bundle.recordings)
    with pytest.raises(BadInput, match=r"bundle.yaml: markers.noise_std_m is null"):
        Engine(replace(bundle, recordings=moving))
