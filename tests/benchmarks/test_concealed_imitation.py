"""An effect counts for what no fabric imitates: what friction could have done is no dry table's secret."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.concealed.case import Case, Plan
from benchmarks.concealed.effects.measurement import GravityTilt
from benchmarks.concealed.effects.tabletop import AnisotropicFriction
from benchmarks.concealed.film import Stage, film, grid_for
from benchmarks.concealed.grips import Poses
from benchmarks.concealed.imitation import Misplaced, imitations, own, unknowns
from benchmarks.concealed.markers import draw_markers
from benchmarks.concealed.motions import MOTIONS
from benchmarks.concealed.strength import Scale, moves_m, rms

NOISE_M = 5e-4
DRIVES = ("left", "right", "bar", "front", "back", "pin")


def plan_of(setting, name: str) -> Plan:
    motion = MOTIONS[name](setting.cloth, setting.columns, setting.rows, np.random.default_rng(0))
    return Plan(name, motion, shown=True, held_out=False)


@pytest.fixture(scope="module")
def table():
    """A sheet that is pulled to and fro on a table, and what each unknown would change of that."""
    setting = replace(Case((), "medium", 3).setting(), places_given=True)
    grid = grid_for(setting)
    markers = draw_markers(setting, grid, np.random.default_rng(1))
    stage = Stage(setting, grid, markers, {drive: np.zeros(3) for drive in DRIVES}).coarser()
    plan = plan_of(setting, "shuttle")
    without = film(stage, plan, [])
    return stage, plan, imitations(stage, [plan], {plan.name: without}), without


def left_of(table, mu_x: float, mu_y: float) -> float:
    """Share of what such a friction changes that nothing else imitates."""
    stage, plan, imitated, without = table
    effect = AnisotropicFriction({"mu_x": mu_x * stage.setting.friction, "mu_y": mu_y * stage.setting.friction})
    change = {plan.name: moves_m([effect], film(stage, plan, [effect]), without)}
    assert rms(change[plan.name]) > 2e-4
    return rms(own(change, imitated, NOISE_M)[plan.name]) / rms(change[plan.name])


def test_more_friction_in_all_directions_is_imitated_by_more_friction(table):
    assert left_of(table, 1.15, 1.15) < 0.25


def test_friction_that_depends_on_the_direction_is_not(table):
    assert left_of(table, 1.4, 0.7) > 0.4


def test_an_effect_of_a_pair_counts_for_what_the_other_does_not_imitate(table):
    """A pull by friction across beside one that is half as strong, and beside a push of another kind."""
    stage, plan, imitated, without = table
    mu = stage.setting.friction
    strong, half = (AnisotropicFriction({"mu_x": (1 + x) * mu, "mu_y": (1 - x) * mu}) for x in (0.4, 0.2))
    tilt = GravityTilt({"tilt_x": 0.05, "tilt_y": 0.0})
    films = {plan.name: without}
    alone = Scale(
        stage=stage,
        rough=stage,
        shown={"anisotropic_friction": [plan]},
        without=films,
        rough_without=films,
        imitated=imitated,
        others={},
    )
    counted = alone.strength("anisotropic_friction", strong, moved := alone.films("anisotropic_friction", strong))
    assert alone.beside("anisotropic_friction", []) is alone
    same, other = (alone.beside("anisotropic_friction", [effect]) for effect in (half, tilt))
    assert same.strength("anisotropic_friction", strong, moved) < 0.4 * counted
    assert 0.6 * counted < other.strength("anisotropic_friction", strong, moved) <= counted


def test_what_unknowns_make_is_taken_off_and_what_is_across_them_stays():
    rng = np.random.default_rng(2)
    columns = rng.normal(size=(50, 4, 3, 2))
    across = rng.normal(size=(50, 4, 3))
    flat = columns.reshape(-1, 2)
    across -= (flat @ np.linalg.lstsq(flat, across.ravel(), rcond=None)[0]).reshape(across.shape)
    left = own({"one": columns @ [3.0, -2.0] + across}, {"one": columns}, noise_m=1e-3)["one"]
    np.testing.assert_allclose(left, across, atol=1e-5)


def test_an_unknown_is_the_same_in_all_motions():
    column = np.random.default_rng(3).normal(size=(50, 4, 3, 1))
    change = column[..., 0]
    left = own({"to": change, "fro": -change}, {"to": column, "fro": column}, noise_m=1e-3)
    np.testing.assert_allclose(left["to"], change, atol=1e-6)


def test_a_fabric_that_priors_make_unlikely_imitates_little():
    column = np.random.default_rng(4).normal(size=(50, 4, 3, 1))
    noise = float(np.linalg.norm(column))  # as far as one spread moves all: no evidence to leave a prior for
    left = own({"one": 3 * column[..., 0]}, {"one": column}, noise_m=noise)["one"]
    np.testing.assert_allclose(left, 1.5 * column[..., 0])


def test_places_are_unknown_where_the_bundle_does_not_give_them():
    setting = Case((), "medium", 3).setting()
    plans = [plan_of(setting, "twist"), plan_of(setting, "fast_swing")]
    drives = {block.drive for plan in plans for block in plan.motion.blocks}
    given = list(unknowns(replace(setting, places_given=True), plans))
    free = list(unknowns(replace(setting, places_given=False), plans))
    assert len(free) - len(given) == 6 * len(drives)
    for unknown in free[len(given) :]:
        (effect,) = unknown.effects
        held = [any(block.drive == effect.drive for block in plan.motion.blocks) for plan in plans]
        assert [unknown.concerns(plan) for plan in plans] == held


def test_a_grip_is_off_in_the_frame_of_its_drive():
    setting = Case((), "medium", 3).setting()
    motion = plan_of(setting, "twist").motion
    drives = [block.drive for block in motion.blocks]
    turned = Rotation.from_rotvec([0.3, -0.2, 1.0]).as_matrix()
    poses = Poses(np.ones((4, len(drives), 3)), np.broadcast_to(turned, (4, len(drives), 3, 3)))
    effect = Misplaced(drive=drives[1], shift_m=np.array([0.01, 0.0, 0.0]), turn_rad=np.array([0.0, 0.0, 0.1]))

    effect.begin(SimpleNamespace(motion=motion))
    off = effect.poses(np.zeros(4), poses)
    np.testing.assert_allclose(off.position_m[:, 1] - 1, np.broadcast_to(0.01 * turned[:, 0], (4, 3)))
    np.testing.assert_allclose(off.rotation[0, 1], turned @ Rotation.from_rotvec([0, 0, 0.1]).as_matrix())
    np.testing.assert_allclose(off.position_m[:, 0], 1.0)
    np.testing.assert_allclose(off.rotation[:, 0], poses.rotation[:, 0])
