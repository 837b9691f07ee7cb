"""Recordings beside simulations: what lasts counts once, noise counts every time."""

import numpy as np
import pytest

from sim1.mismatch.compare import LASTING_S, Observed

BLOCKS, MARKERS, NOISE_M = 30, 6, 3e-4


@pytest.fixture(scope="module")
def observed():
    """Irregular times, gaps, one block without a marker, a discrepancy that differs from number to number."""
    stream = np.random.default_rng(0)
    kept = stream.random((BLOCKS, MARKERS)) > 0.2
    kept[5] = False
    kept = np.repeat(kept[..., None], 3, axis=2)
    return Observed(
        measured_m=np.zeros(kept.sum()),
        kept=kept,
        starts=np.arange(BLOCKS),
        weight=np.ones((BLOCKS, MARKERS)),
        block_s=np.sort(stream.random(BLOCKS)) * 2.0,
        noise_m=NOISE_M,
        mesh_m=1e-3 * stream.random(kept.sum()),
    )


def covariance_of(one):
    """Of all numbers (K, K), written down as the model says it."""
    block, marker, axis = np.argwhere(one.kept).T
    away_s = np.abs(one.block_s[block][:, None] - one.block_s[block])
    same = (marker[:, None] == marker) & (axis[:, None] == axis)
    alike = np.exp(-away_s / LASTING_S) * same
    return one.mesh_m[:, None] * alike * one.mesh_m + NOISE_M**2 * np.eye(len(block))


def test_whitened_numbers_are_independent_with_variance_one(observed):
    white = observed.white(np.eye(len(observed.measured_m)))
    assert white @ covariance_of(observed) @ white.T == pytest.approx(np.eye(len(white)), abs=1e-9)


def test_an_error_that_lasts_counts_less_than_the_same_errors_at_random(observed):
    stream = np.random.default_rng(1)
    lasting = 3 * observed.mesh_m
    lasts, jumps = (
        np.square(observed.white(one)).sum() for one in (lasting, lasting * stream.choice([-1, 1], size=len(lasting)))
    )
    assert lasts < 0.2 * jumps


def test_slopes_are_whitened_as_residuals_are(observed):
    values = np.random.default_rng(2).normal(size=(len(observed.measured_m), 4))
    assert observed.white(values)[:, 2] == pytest.approx(observed.white(values[:, 2]))
