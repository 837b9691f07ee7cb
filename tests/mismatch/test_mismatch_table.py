"""What a table does to the identification simulator's sheet: adhesion, sticking and sliding, against their formulas."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import SIDE_M, empty_bundle, plain_world

from sim1.cloth.precise import march
from sim1.cloth.precise.forces import residual
from sim1.cloth.precise.march import SLIDING_M_S
from sim1.cloth.precise.scene import prepare
from sim1.cloth.precise.simulate import NotConverged, simulate
from sim1.cloth.precise.world import pack


@pytest.fixture(scope="module")
def bundle():
    return empty_bundle(duration_s=1.5)


@pytest.fixture(scope="module")
def world(bundle):
    return replace(plain_world(bundle), heavy_patch=(0.1, 0.15, 0.0))


def table_force_n(bundle, world, gap_m, speed_m_s=0.0, regularised_m_s=1e-6):
    """What holds a flat sheet back, (3,), that far above the table and sliding along x; residuals are what has to be overcome."""
    scene = prepare(bundle, bundle.recordings[0], 1 / 60)
    x = np.column_stack([scene.sheet.material_m, np.full(len(scene.start), gap_m)])
    v = np.zeros_like(x)
    v[:, 0] = speed_m_s
    none = np.zeros((len(scene.net.first) - 1, 3))
    free, target = np.zeros(len(scene.net.held), bool), np.zeros((len(scene.net.held), 3))
    sides = []
    for table_z_m in (0.0, None):
        out, cloth = np.empty_like(x), pack(scene.sheet, [replace(world, table_z_m=table_z_m)])
        residual(x, v, 0.0 * x, regularised_m_s, scene.net, cloth, 0, none, none, none, target, free, out)
        sides.append(out.sum(0))
    return sides[0] - sides[1]


@pytest.mark.parametrize("reach", [5e-4, 2e-3])
def test_adhesion_pulls_with_its_pressure_in_contact_and_fades_out_over_its_reach(bundle, world, reach):
    clinging = replace(world, adhesion_pa=2.0, cling_m=reach, friction=0.4)
    for gap, share in ((0.0, 1.0), (0.25 * reach, 0.75), (0.9 * reach, 0.1), (1.1 * reach, 0.0)):
        assert table_force_n(bundle, clinging, gap)[2] == pytest.approx(share * 2.0 * SIDE_M**2, abs=1e-9)


def test_what_sticks_beyond_sliding_friction_fades_by_the_stribeck_speed(bundle, world):
    """mu N (1 + (ratio - 1) exp(-(v / speed)^2)), the last factor 1/e at the speed itself."""
    sliding = replace(world, friction=0.4, stribeck_m_s=0.02)
    for speed in (0.01, 0.02, 0.05):
        plain, sticking = (
            table_force_n(bundle, replace(sliding, stiction=ratio), -5e-5, speed)[0] for ratio in (1.0, 1.5)
        )
        assert plain == pytest.approx(0.4 * 3.0 * SIDE_M**2, rel=1e-3)  # 0.05 mm deep: 3 Pa
        assert sticking / plain == pytest.approx(1.0 + 0.5 * np.exp(-((speed / 0.02) ** 2)), rel=1e-3)


# Friction, table [m], how far along it and how low a sheet is brought [m]: some step of each is not found at once.
DRAGGED = (
    (0.8830, 0.41116, 0.28351, 0.13578),
    (1.3576, 0.38086, 0.13607, 0.19949),
    (1.1015, 0.41667, 0.28143, 0.17482),
    (0.5788, 0.39990, 0.21093, 0.17258),
    (0.3976, 0.41002, 0.28543, 0.12619),
)


def test_a_step_that_friction_hides_is_found_by_way_of_a_softer_friction(world, monkeypatch):
    """Laid down, dragged and lifted, without halving a step, and no marker leaps."""
    bundle = empty_bundle(duration_s=2.5)
    (bar,) = bundle.recordings[0].drives.values()
    share = np.sin(np.pi * np.clip((bar.time_s - 0.3) / 2.0, 0.0, 1.0))

    def dragged(friction, table, along, down):
        path = np.column_stack([0.0 * share, along * share, 0.6 - down * share**2])
        recording = replace(bundle.recordings[0], drives={"bar": replace(bar, position_m=path)})
        there = replace(plain_world(bundle), table_z_m=table, friction=friction)
        return simulate(prepare(bundle, recording, 1 / 60), [there], halvings=0).markers_m[0]

    found = [dragged(*one) for one in DRAGGED]
    monkeypatch.setattr(march, "TRIES", march.TRIES[:2])
    missed = 0
    for one, markers_m in zip(DRAGGED, found, strict=True):
        try:
            dragged(*one)
        except NotConverged:
            missed += 1
        assert np.linalg.norm(np.diff(markers_m, axis=0), axis=-1).max() * 60 < 3.0  # m/s
    assert missed


def test_friction_holds_what_creeps_at_a_millimetre_a_second_nearly_as_what_slides(bundle, world):
    """What is short of it there, recordings of a sheet that sticks would take for a sticking friction of its own."""
    creeping, sliding = (
        table_force_n(bundle, replace(world, friction=0.4), -5e-5, speed, SLIDING_M_S)[0] for speed in (1e-3, 0.1)
    )
    assert 0.95 < creeping / sliding < 1.0
