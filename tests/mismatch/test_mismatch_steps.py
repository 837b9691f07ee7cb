"""What a simulation does when a step has no answer, and when a twin strays."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle, plain_world

from sim1.cloth.precise import simulate as module
from sim1.cloth.precise.arrays import ADHESION, AIR_NORMAL, CLING, STICTION, STRIBECK, WIND_X, WIND_Z
from sim1.cloth.precise.scene import prepare
from sim1.cloth.precise.simulate import NotConverged, simulate
from sim1.cloth.precise.twins import FARTHEST_M, LOST, keep_near
from sim1.cloth.precise.world import pack


@pytest.fixture(scope="module")
def bundle():
    return empty_bundle(duration_s=1.2, motions=1)


@pytest.fixture(scope="module")
def world(bundle):
    return plain_world(bundle)


def failing(times, at=7):
    """`march` that finds no state at step `at` the first few times."""
    march, left = module.march, [times]

    def instead(*args):
        left[0] -= 1
        return at if left[0] >= 0 else march(*args)

    return instead


def test_a_step_without_an_answer_is_halved_and_the_result_is_the_same(bundle, world, monkeypatch):
    scene = prepare(bundle, bundle.recordings[0], 1 / 240)
    twin = replace(world, bending_n_m=1.0001 * world.bending_n_m)
    whole = simulate(scene, [world, twin], leads=True)
    monkeypatch.setattr(module, "march", failing(1))
    halved = simulate(scene, [world, twin], leads=True)
    assert halved.shapes_m.shape == whole.shapes_m.shape
    assert halved.leads_m.shape == whole.leads_m.shape
    moved = np.abs(whole.markers_m[0] - whole.markers_m[0, 0]).max()
    assert np.abs(halved.markers_m - whole.markers_m).max() < 0.01 * moved


def test_a_motion_that_cannot_be_followed_is_named_with_its_time(bundle, world, monkeypatch):
    scene = prepare(bundle, bundle.recordings[0], 1 / 60)
    monkeypatch.setattr(module, "march", failing(3, at=8))
    with pytest.raises(NotConverged, match=rf"^recording swing_0: no next state at {scene.time_s[0] + 2 / 60:.3f} s"):
        simulate(scene, [world])


def test_a_sheet_that_finds_no_rest_is_named(bundle, world, monkeypatch):
    monkeypatch.setattr(module, "rest", lambda *_: False)
    with pytest.raises(NotConverged, match=r"^recording swing_0: the sheet finds no rest"):
        simulate(prepare(bundle, bundle.recordings[0], 1 / 60), [world])


@pytest.fixture
def strayed(bundle, world):
    """Arguments of `keep_near` for a base and four twins: close by, astray, chaotic, not finite."""
    scene = prepare(bundle, bundle.recordings[0], 1 / 60)
    cloth = pack(scene.sheet, [world, *(replace(world, bending_n_m=2 * world.bending_n_m) for _ in range(4))])
    leads = np.array([0.0, 0.1 * FARTHEST_M, 100 * FARTHEST_M, 100 * FARTHEST_M, np.nan])
    x = scene.start + leads[:, None, None] * np.ones(3)
    stencils, steps = len(scene.net.first) - 1, len(scene.time_s)
    paths = np.repeat(np.stack([scene.paths(world)]), 5, axis=0)
    goals = np.zeros((5, steps, 2, 3))
    state = [x.copy() for _ in range(6)]
    memory = [np.zeros((5, stencils, 3)) for _ in range(3)]
    size_of, lost = np.array([1.0, 1.0, 5.0, 2 * LOST, 1.0]), np.zeros(5, bool)
    return *state, cloth, paths, *memory, np.zeros((5, 1, 3)), goals, goals.copy(), size_of, lost


def test_a_twin_that_strays_is_brought_near_and_says_the_same(strayed):
    x, cloth, size_of, lost = strayed[0], strayed[6], strayed[-2], strayed[-1]
    before, bend = x.copy(), cloth.bend.copy()
    keep_near(*strayed)
    assert (x[1] == before[1]).all()
    np.testing.assert_allclose(size_of[2] * (x[2] - x[0]), 5.0 * (before[2] - before[0]), rtol=1e-6)
    np.testing.assert_allclose(cloth.bend[2] - bend[0], 1e-3 * (bend[2] - bend[0]), rtol=1e-6, atol=1e-18)
    assert np.abs(x[2] - x[0]).max() == pytest.approx(0.1 * FARTHEST_M)
    assert lost.tolist() == [False, False, False, True, True]


def test_a_twin_that_is_lost_becomes_the_base(strayed):
    keep_near(*strayed)
    for part in strayed[:6]:
        assert (part[3:] == part[0]).all()
    assert (strayed[6].bend[3:] == strayed[6].bend[0]).all()


def astray(bundle, world, *twins):
    """Arguments of `keep_near` for twins that are all a hundred times too far from the base."""
    scene = prepare(bundle, bundle.recordings[0], 1 / 60)
    cloth, count = pack(scene.sheet, [world, *twins]), len(twins) + 1
    x = scene.start + 100 * FARTHEST_M * np.array([0.0, *[1.0] * len(twins)])[:, None, None] * np.ones(3)
    stencils, steps = len(scene.net.first) - 1, len(scene.time_s)
    paths, goals = np.repeat(np.stack([scene.paths(world)]), count, axis=0), np.zeros((count, steps, 2, 3))
    state, memory = [x.copy() for _ in range(6)], [np.zeros((count, stencils, 3)) for _ in range(3)]
    offset = np.zeros((count, 1, 3))
    return *state, cloth, paths, *memory, offset, goals, goals.copy(), np.ones(count), np.zeros(count, bool)


def test_of_an_effect_that_the_base_lacks_its_strength_is_scaled_and_not_its_direction_or_range(bundle, world):
    windy = replace(world, air_normal=0.1, wind_m_s=(0.6, -0.2, 0.1))
    sticky, stuck = replace(world, adhesion_pa=0.2, cling_m=0.002), replace(world, stiction=1.01, stribeck_m_s=0.06)
    given = astray(bundle, world, windy, sticky, stuck)
    scalar = given[6].scalar
    before = scalar.copy()
    keep_near(*given)
    shrink = scalar[1, AIR_NORMAL] / before[1, AIR_NORMAL]
    assert shrink == pytest.approx(1e-3)
    assert scalar[1, WIND_X : WIND_Z + 1] == pytest.approx(windy.wind_m_s)
    assert (scalar[2, CLING], scalar[3, STRIBECK]) == (sticky.cling_m, stuck.stribeck_m_s)
    assert scalar[2, ADHESION] == pytest.approx(shrink * sticky.adhesion_pa)
    assert scalar[3, STICTION] - 1.0 == pytest.approx(0.01 * shrink)


def test_where_the_base_blows_the_wind_of_a_twin_is_brought_near_too(bundle, world):
    blown = replace(world, air_normal=0.1, wind_m_s=(0.6, 0.0, 0.0))
    given = astray(bundle, blown, replace(blown, wind_m_s=(0.7, 0.0, 0.0)))
    keep_near(*given)
    assert given[6].scalar[1, WIND_X] == pytest.approx(0.6 + 1e-4)


@pytest.mark.parametrize(("rubs", "kept"), [(0.0, 0.9), (1e-5, 0.9 * 1e-3)])
def test_how_a_sheet_has_turned_so_far_is_scaled_only_where_the_base_remembers_it_too(bundle, world, rubs, kept):
    given = astray(bundle, replace(world, hysteresis_n=rubs), replace(world, hysteresis_n=rubs + 1e-6))
    moment = given[9]
    moment[1] = 0.9
    keep_near(*given)
    assert moment[1] == pytest.approx(np.full_like(moment[1], kept))
