"""Recordings beside simulations: what lasts counts once, noise counts every time."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from small_bundle import empty_bundle, plain_world

from sim1.cloth.precise.scene import prepare
from sim1.mismatch.compare import LASTING_S, Observed, observe
from sim1.mismatch.fit import LEAST_TEMPER, temper_of

BLOCKS, MARKERS, NOISE_M = 30, 6, 3e-4


@pytest.fixture(scope="module", params=[0.0, 2e-3], ids=["steady", "creeping"])
def observed(request):
    """Irregular times, gaps, one block without a marker, a discrepancy that differs from number to number."""
    stream, creep_m = np.random.default_rng(0), request.param
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
        creep_m=creep_m,
        mesh_m=1e-3 * stream.random(kept.sum()),
    )


def covariance_of(one):
    """Of all numbers (K, K), written down as the model says it."""
    block, marker, axis = np.argwhere(one.kept).T
    away_s = np.abs(one.block_s[block][:, None] - one.block_s[block])
    same = (marker[:, None] == marker) & (axis[:, None] == axis)
    alike = np.exp(-away_s / LASTING_S) * same
    return (one.mesh_m[:, None] * one.mesh_m + one.creep_m**2) * alike + NOISE_M**2 * np.eye(len(block))


def test_whitened_numbers_are_independent_with_variance_one(observed):
    white = observed.white(np.eye(len(observed.measured_m)))
    assert white @ covariance_of(observed) @ white.T == pytest.approx(np.eye(len(white)), abs=1e-9)


def test_an_error_that_lasts_counts_less_than_the_same_errors_at_random(observed):
    stream = np.random.default_rng(1)
    lasting = 3 * np.hypot(observed.mesh_m, observed.creep_m)
    lasts, jumps = (
        np.square(observed.white(one)).sum() for one in (lasting, lasting * stream.choice([-1, 1], size=len(lasting)))
    )
    assert lasts < 0.2 * jumps


def test_slopes_are_whitened_as_residuals_are(observed):
    values = np.random.default_rng(2).normal(size=(len(observed.measured_m), 4))
    assert observed.white(values)[:, 2] == pytest.approx(observed.white(values[:, 2]))


def test_markers_that_creep_together_count_as_one(observed):
    """Where markers keep their places, neighbours are taken to share errors by a fixed number."""
    engine = SimpleNamespace(observed=lambda name: observed)
    stream = np.random.default_rng(3)
    block, _, axis = np.argwhere(observed.kept).T
    alone, alike = stream.standard_normal(len(block)), stream.standard_normal((BLOCKS, 3))[block, axis]
    assert temper_of(engine, {"a": alone}, ("a",)) == {"a": LEAST_TEMPER}
    expected = 0.8 * MARKERS if observed.creep_m else LEAST_TEMPER  # a fifth of the markers are not seen
    assert temper_of(engine, {"a": alike}, ("a",))["a"] == pytest.approx(expected, rel=0.3)


@pytest.mark.parametrize("offset_s", [0.1, 0.4])
def test_no_delay_is_charged_for_what_drives_did_before_a_recording_that_starts_moving(offset_s):
    """Frames before which simulated drives stand are compared in no model; in a recording that starts at rest all are."""
    bundle = empty_bundle(motions=2)
    for starts in ("moving", "rest"):
        recording = replace(bundle.recordings[1], starts=starts)
        scene, one = prepare(bundle, recording, 1 / 60), observe(recording)
        clock = np.broadcast_to(scene.time_s[:, None, None], (len(scene.time_s), one.kept.shape[1], 3))
        seen_s = one.reduce(scene.observed(clock, replace(plain_world(bundle), clock_offset_s=offset_s)))
        at_s = one.reduce(np.broadcast_to(recording.time_s[:, None, None], recording.markers_m.shape))
        if starts == "moving":
            np.testing.assert_allclose(seen_s, at_s - offset_s, atol=1e-6)
        else:
            assert one.kept.all()
