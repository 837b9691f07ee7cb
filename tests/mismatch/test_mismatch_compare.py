"""Recordings beside simulations: what lasts and is shared counts once, noise counts every time."""

import numpy as np
import pytest

from sim1.mismatch.compare import LASTING_S, SHARED, Observed

BLOCKS, MARKERS, NOISE_M = 30, 6, 3e-4


@pytest.fixture(scope="module")
def observed():
    """Irregular times, gaps, one block without a marker, a discrepancy that differs from number to number."""
    stream = np.random.default_rng(0)
    kept = stream.random((BLOCKS, MARKERS)) > 0.2
    kept[5] = False
    kept = np.repeat(kept[..., None], 3, axis=2)
    return Observed(
        place_m=stream.random((MARKERS, 2)),
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
    size_m = np.linalg.norm(np.ptp(one.place_m, axis=0))
    away_s = np.abs(one.block_s[block][:, None] - one.block_s[block])
    away_m = np.linalg.norm(one.place_m[marker][:, None] - one.place_m[marker], axis=-1)
    alike = np.exp(-away_s / LASTING_S - away_m / (SHARED * size_m)) * (axis[:, None] == axis)
    return one.mesh_m[:, None] * alike * one.mesh_m + NOISE_M**2 * np.eye(len(block))


def test_whitened_numbers_are_independent_with_variance_one(observed):
    white = observed.white(np.eye(len(observed.measured_m)))
    assert white @ covariance_of(observed) @ white.T == pytest.approx(np.eye(len(white)), abs=1e-9)


def test_a_shift_of_the_whole_sheet_counts_less_than_the_same_shifts_at_random(observed):
    stream = np.random.default_rng(1)
    shift = 3 * observed.mesh_m
    together, apart = (
        np.square(observed.white(one)).sum() for one in (shift, shift * stream.choice([-1, 1], size=len(shift)))
    )
    assert together < 0.2 * apart


def test_slopes_are_whitened_as_residuals_are(observed):
    values = np.random.default_rng(2).normal(size=(len(observed.measured_m), 4))
    assert observed.white(values)[:, 2] == pytest.approx(observed.white(values[:, 2]))
