"""The force that one world has and another lacks, against formulas."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import SIDE_M, empty_bundle

from sim1.cloth.effects import EFFECTS
from sim1.cloth.precise.lacking import cloth_part, lacking_force, lacking_forces

STEP_S, SPEED_M_S = 1 / 60, 0.8


@pytest.fixture(scope="module")
def bundle():
    return empty_bundle()


@pytest.fixture(scope="module")
def sinking(scene):
    """A flat sheet (T, V, 3) that sinks at a steady speed."""
    flat = np.column_stack([scene.sheet.material_m, np.zeros(len(scene.sheet.material_m))])
    return flat - np.arange(10)[:, None, None] * STEP_S * np.array([0.0, 0.0, SPEED_M_S])


def test_drag_pushes_against_the_motion_by_its_formula(scene, world, sinking):
    force = lacking_force(scene, replace(world, air_normal=1.5), world, sinking)
    expected = 0.5 * world.air_density_kg_m3 * 1.5 * SPEED_M_S**2 * SIDE_M**2 / force.shape[1]
    assert force[..., 2] == pytest.approx(np.full(force.shape[:2], expected), rel=1e-6)
    assert np.abs(force[..., :2]).max() < 1e-9


def test_a_weight_pulls_where_it_is(scene, world, sinking):
    place = scene.sheet.material_m.mean(0)
    force = lacking_force(scene, replace(world, heavy_patch=(*place, 2e-3)), world, sinking)[5, :, 2]
    points = (scene.sheet.material_m[scene.net.marker_node] * scene.net.marker_weight[..., None]).sum(1)
    order = np.argsort(np.linalg.norm(points - place, axis=1))
    assert (force < 0.0).all()  # downwards
    assert force[order[:4]].max() < 3 * force[order[4:]].min()  # a bell of one cell, as the mesh holds it


def test_several_worlds_at_once_push_as_each_does_alone(scene, world, sinking):
    several = [replace(world, air_normal=1.5), replace(world, hysteresis_n=1e-4), replace(world, curl_1_m=(2.0, 0.0))]
    together = lacking_forces(scene, several, world, sinking)
    for force, one in zip(together, several, strict=True):
        assert np.array_equal(force, lacking_force(scene, one, world, sinking))
    assert np.abs(together[2]).max() > 0.0


def test_worlds_that_are_alike_lack_nothing(scene, world, sinking):
    assert np.abs(lacking_force(scene, world, world, sinking)).max() == 0.0


def test_what_acts_through_the_rig_alone_is_no_force_on_the_cloth(world):
    late = replace(world, lag_s=0.02, clock_offset_s=0.01, compliance_m_n=1e-3)
    assert cloth_part(late, world) == world
    assert cloth_part(replace(late, air_skin=0.1), world) != world


@pytest.mark.parametrize("name", sorted(e.name for e in EFFECTS.values() if e.measured and e.name != "gravity_tilt"))
def test_what_the_rig_and_cameras_do_is_no_force_on_the_cloth(world, name):
    """Thresholds too: a slip that was named was looked for on the cloth, and found to be nothing anywhere."""
    effect = EFFECTS[name]
    values = {c.name: c.value(0.7) for c in effect.coefficients}
    model = effect.alter(world, values)
    assert model != world
    assert cloth_part(model, world) == world
