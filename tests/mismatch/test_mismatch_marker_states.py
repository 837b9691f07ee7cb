"""States of the sheet at its markers, against shapes that are known."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import SIDE_M, empty_bundle

from sim1.cloth.precise.marker_states import marker_states
from sim1.cloth.precise.material import marker_points


@pytest.fixture(scope="module")
def bundle():
    return empty_bundle(duration_s=1.2, motions=1)


def states(scene, shape_m):
    return marker_states(scene, np.repeat(shape_m[None], len(scene.time_s), axis=0))


def test_a_flat_stretched_sheet_has_strain_and_no_curvature(scene):
    u, v = scene.sheet.material_m.T
    found = states(scene, np.column_stack([1.02 * u, 0.0 * u, -0.99 * v]))
    strain = found.strain.reshape(-1, 3)
    np.testing.assert_allclose(
        strain, np.tile([0.5 * (1.02**2 - 1), 0.5 * (0.99**2 - 1), 0.0], (len(strain), 1)), atol=1e-9
    )
    np.testing.assert_allclose(found.curvature_1_m, 0.0, atol=1e-9)
    np.testing.assert_allclose(found.normal, np.broadcast_to([0.0, 1.0, 0.0], found.normal.shape), atol=1e-9)
    np.testing.assert_allclose(
        found.threads[..., 1, :], np.broadcast_to([0.0, 0.0, -1.0], found.normal.shape), atol=1e-9
    )


def test_a_sheet_rolled_along_one_thread_is_bent_along_it_towards_its_normal(scene):
    u, v = scene.sheet.material_m.T
    radius = 1.0
    found = states(scene, np.column_stack([u, radius * (1 - np.cos(v / radius)), -radius * np.sin(v / radius)]))
    np.testing.assert_allclose(found.curvature_1_m[..., 1], 1.0 / radius, rtol=5e-3)
    np.testing.assert_allclose(found.curvature_1_m[..., [0, 2]], 0.0, atol=1e-6)
    sheared = states(scene, np.column_stack([u + 0.01 * v, 0.0 * u, -v]))
    np.testing.assert_allclose(sheared.strain[..., 2], 0.005, rtol=1e-6)


def test_grips_are_as_far_off_as_the_cloth_between_is_long_and_infinitely_once_they_let_go(scene, bundle):
    active = scene.time_s < 0.6
    letting = replace(scene, grips=tuple(replace(grip, active=active) for grip in scene.grips))
    found = states(letting, np.column_stack([scene.sheet.material_m, np.zeros(len(scene.sheet.material_m))]))
    points = marker_points(bundle)
    spacing = SIDE_M / 6  # of the held vertices along the bar
    along = np.abs(points[:, 0] / spacing - np.round(points[:, 0] / spacing)) * spacing
    expected = np.hypot(points[:, 1], along)
    np.testing.assert_allclose(found.grip_m[active], np.broadcast_to(expected, (active.sum(), len(points))), atol=1e-12)
    assert np.isinf(found.grip_m[~active]).all()
    assert np.isinf(found.at(~active).grip_m).all()
