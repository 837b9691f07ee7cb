"""The identification simulator against theory, refinement and differences."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import SIDE_M, empty_bundle, plain_world

from sim1.cloth.effects import EFFECTS
from sim1.cloth.precise.forces import residual
from sim1.cloth.precise.jaws import coupling
from sim1.cloth.precise.newton import net_width
from sim1.cloth.precise.scene import prepare
from sim1.cloth.precise.simulate import simulate
from sim1.cloth.precise.stiffness import derivative
from sim1.cloth.precise.twins import FARTHEST_M
from sim1.cloth.precise.world import pack
from sim1.mismatch.search import Term


@pytest.fixture(scope="module")
def bundle():
    return empty_bundle(duration_s=1.5)


@pytest.fixture(scope="module")
def world(bundle):
    return replace(plain_world(bundle), heavy_patch=(0.1, 0.15, 0.0))


def test_a_hanging_sheet_stretches_as_its_weight_says(bundle, world):
    """Mean strain of a strip under its own weight: rho g L / (2 E)."""
    soft = replace(world, poisson=0.0, stretch_n_m=100.0)
    scene = prepare(bundle, bundle.recordings[0], 1 / 60)
    rest = simulate(scene, [soft]).rest_m
    drop = rest[:, 2].max() - rest[:, 2].min()
    expected = SIDE_M * (1 + soft.area_density_kg_m2 * 9.81 * SIDE_M / (2 * soft.stretch_n_m))
    assert drop - SIDE_M == pytest.approx(expected - SIDE_M, rel=0.02)


def test_a_sheet_that_is_let_go_falls_freely(bundle, world):
    recording = bundle.recordings[0]
    holds = tuple(replace(hold, to_s=0.6) for hold in recording.holds)
    scene = prepare(bundle, replace(recording, holds=holds), 1 / 240)
    run = simulate(scene, [world])
    middle = run.shapes_m[:, :, 2].mean(1)
    time = scene.time_s - 0.6
    late = time > 0.1
    curvature = np.polyfit(time[late], middle[late], 2)[0]
    assert 2 * curvature == pytest.approx(-9.81, rel=2e-3)


def test_halving_the_step_quarters_the_error(bundle, world):
    recording = bundle.recordings[1]
    fine = simulate(prepare(bundle, recording, 1 / 960), [world]).markers_m[0]
    errors = [
        np.sqrt(np.mean((simulate(prepare(bundle, recording, step), [world]).markers_m[0] - fine) ** 2))
        for step in (1 / 60, 1 / 120)
    ]
    assert errors[0] / errors[1] > 3.0


VARIED = {
    "stretch_n_m": 330.0,
    "bending_n_m": 2.005e-4,
    "damping_s": 2.2e-3,
    "air_normal": 0.1,
    "added_mass_kg_m2": 0.002,
    "scale": (1.001, 1.0),
    "curl_1_m": (0.05, 0.0),
    "lag_s": 0.001,
    "clock_offset_s": 0.001,
    "tilt_rad": (0.002, 0.0),
    "heavy_patch": (0.1, 0.15, 5e-5),
}


def part_of_the_way(world, name, value, share):
    """A world whose field lies between that of `world` and `value`."""
    start = np.array(getattr(world, name), float)
    mixed = start + share * (np.array(value) - start)
    return replace(world, **{name: float(mixed) if mixed.ndim == 0 else tuple(float(x) for x in mixed)})


def test_a_twin_says_what_another_simulation_would(bundle, world):
    scene = prepare(bundle, bundle.recordings[0], 1 / 60)
    run = simulate(scene, [world, *(part_of_the_way(world, name, value, 1e-3) for name, value in VARIED.items())])
    for name, told in zip(VARIED, run.markers_m[1:], strict=True):
        other = replace(world, **{name: VARIED[name]})
        change = simulate(scene, [other], near=run.rest_m).markers_m[0] - run.markers_m[0]
        off = np.sqrt(np.mean((1e3 * (told - run.markers_m[0]) - change) ** 2))
        assert off < 0.1 * np.sqrt(np.mean(change**2)) + 5e-7, name


ABSENT = {
    "wind": ("air_normal", 0.05, {"wind_m_s": (0.2, 0.6, 0.0)}),
    "bending_hysteresis": ("hysteresis_n", 2e-5, {"turn_1_m": 1.5}),
}


@pytest.mark.parametrize("effect", ABSENT)
def test_a_twin_with_an_effect_that_the_base_lacks_says_what_another_simulation_would(bundle, world, effect):
    """It strays by more than a micrometre and is brought near again and again; which way the wind blows, and what has rubbed, stay."""
    field, strength, shape = ABSENT[effect]
    scene = prepare(bundle, bundle.recordings[0], 1 / 60)
    twin, other = (replace(world, **{field: share * strength}, **shape) for share in (1e-2, 1.0))
    run = simulate(scene, [world, twin])
    told = 1e2 * (run.markers_m[1] - run.markers_m[0])
    change = simulate(scene, [other], near=run.rest_m).markers_m[0] - run.markers_m[0]
    assert np.abs(told).max() > 1e2 * FARTHEST_M
    assert np.sqrt(np.mean((told - change) ** 2)) < 0.1 * np.sqrt(np.mean(change**2))


def test_a_bent_sheet_that_turns_as_a_whole_is_not_damped(bundle, world):
    scene = prepare(bundle, bundle.recordings[0], 1 / 60)
    u, v = scene.sheet.material_m.T
    x = np.column_stack([np.sin(8.0 * u) / 8.0, -v, np.cos(8.0 * u) / 8.0])
    turning = np.cross([0.7, -1.1, 0.4], x)
    bending = np.column_stack([0.0 * u, 0.0 * u, np.sin(20.0 * u) / 20.0])
    shape = (len(scene.net.first) - 1, 3)
    still, free = np.zeros(shape), np.zeros(len(scene.net.held), bool)
    target = np.zeros((len(scene.net.held), 3))

    def damping(velocity):
        """Power that the material takes at this velocity."""
        power = []
        for tau in (0.0, 0.01):
            cloth = pack(scene.sheet, [replace(world, damping_s=tau, stretch_n_m=1e-6)])
            out = np.empty_like(x)
            residual(x, velocity, 0.0 * x, 1e-3, scene.net, cloth, 0, still, still, still, target, free, out)
            power.append((out * velocity).sum())
        return power[1] - power[0]

    assert damping(bending) > 0.0
    assert abs(damping(turning)) < 1e-3 * damping(bending)


def test_one_round_is_enough_for_a_twin(bundle, world, monkeypatch):
    scene = prepare(bundle, bundle.recordings[1], 1 / 60, finer=1)
    twins = [part_of_the_way(world, name, value, 1e-4) for name, value in VARIED.items()]
    usual = simulate(scene, [world, *twins]).markers_m
    monkeypatch.setattr("sim1.cloth.precise.simulate.ROUNDS", 6)
    careful = simulate(scene, [world, *twins]).markers_m
    for name, one, other in zip(VARIED, usual[1:] - usual[0], careful[1:] - careful[0], strict=True):
        assert np.sqrt(np.mean((one - other) ** 2)) < 0.02 * np.sqrt(np.mean(other**2)), name


def test_a_jaw_that_yields_sinks_by_its_load_and_keeps_the_shape(bundle, world):
    scene = prepare(bundle, bundle.recordings[0], 1 / 60)
    firm, soft = (simulate(scene, [replace(world, compliance_m_n=c)]).rest_m for c in (0.0, 2e-3))
    weight = 9.81 * world.area_density_kg_m2 * SIDE_M**2
    assert soft - firm == pytest.approx(np.broadcast_to([0.0, 0.0, -2e-3 * weight], firm.shape), abs=2e-6)


@pytest.mark.parametrize("compliance", [0.0, 2e-3])
def test_a_twin_tells_of_a_yielding_grip(bundle, world, compliance):
    scene, little = prepare(bundle, bundle.recordings[0], 1 / 60), 4e-4
    worlds = [replace(world, compliance_m_n=compliance + part * little) for part in (0.0, 0.01, 1.0)]
    run = simulate(scene, worlds[:2])
    change = simulate(scene, worlds[2:]).markers_m[0] - run.markers_m[0]
    told = 100 * (run.markers_m[1] - run.markers_m[0])
    assert np.sqrt(np.mean((told - change) ** 2)) < 0.1 * np.sqrt(np.mean(change**2))


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"stiffening": 50.0},
        {"air_normal": 2.0},
        {"added_mass_kg_m2": 0.1},
        {"table_z_m": 0.45, "friction": 0.4},
        {"compliance_m_n": 2e-3},
        {"hysteresis_n": 1e-4},
        {"curl_1_m": (3.0, 1.0)},
    ],
)
def test_the_matrix_is_the_derivative_of_the_forces(bundle, world, change):
    world = replace(world, damping_s=1e-5, **change)
    scene = prepare(bundle, bundle.recordings[0], 1 / 60)
    net, cloth = scene.net, pack(scene.sheet, [world])
    stream = np.random.default_rng(0)
    x = 1.01 * scene.start + 1e-4 * stream.standard_normal(scene.start.shape)
    v, acc, way = (scale * stream.standard_normal(x.shape) for scale in (1e-3, 1.0, 1.0))
    rate, mass_rate, tiny = 90.0, 8100.0, 1e-7
    none = np.zeros((len(net.first) - 1, 3))
    target, on = np.ascontiguousarray(scene.paths(world)[0]), np.full(len(net.held), world.compliance_m_n > 0.0)
    band = np.empty((x.size, 3 * net_width(net) + 3))
    derivative(x, v, mass_rate, rate, 1e-3, net, cloth, none, none, on, False, band)
    sides = []
    for sign in (1, -1):
        out = np.empty_like(x)
        moved = sign * tiny * way
        residual(
            x + moved, v + rate * moved, acc + mass_rate * moved, 1e-3, net, cloth, 0, none, none, none, target, on, out
        )
        sides.append(out)
    expected = ((sides[0] - sides[1]) / (2 * tiny)).ravel()
    full = np.zeros((x.size, x.size))
    for j in range(x.size):
        rows = min(band.shape[1], x.size - j)
        full[j : j + rows, j] = band[j, :rows]
        full[j, j : j + rows] = band[j, :rows]
    rows = coupling(net, on, world.compliance_m_n, x.size)
    full -= rows.T @ rows
    off = np.abs(full @ way.ravel() - expected)
    if (
        "table_z_m" in change
    ):  # friction takes the secant, so that its part is positive: sliding directions are left out
        off = off.reshape(-1, 3)[:, 2]
    assert off.max() < 2e-3 * np.abs(expected).max()


IN_NO_ARRAY = ("lag_s", "clock_offset_s", "frame_shift_m", "frame_turn_rad")  # acts on drives and markers


def filled(cloth):
    """The arrays that are there: no effect has a push without a name."""
    return [part for part in cloth if part is not None]


@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_an_effect_is_absent_at_zero_and_reads_back_from_its_parameters(bundle, world, name):
    effect = EFFECTS[name]
    term = Term.of(effect, {})
    absent = effect.alter(world, {c.name: c.value(0.0) for c in term.coefficients})
    scene = prepare(bundle, bundle.recordings[0], 1 / 60)
    plain, without = pack(scene.sheet, [world]), pack(scene.sheet, [absent])
    if name not in (
        "grip_slip",
        "plastic_crease",
        "wind",
    ):  # their thresholds and streams are set while they do nothing
        for a, b in zip(filled(plain), filled(without), strict=True):
            np.testing.assert_allclose(a, b, rtol=1e-12)
    values = {c.name: c.value(0.7) for c in term.coefficients}
    present = effect.alter(replace(world, friction=0.4), values)
    published = effect.published(present, values)
    assert set(published) == set(effect.units())
    again = effect(**published).act(replace(world, friction=0.4))
    for a, b in zip(filled(pack(scene.sheet, [present])), filled(pack(scene.sheet, [again])), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9)
    for field in IN_NO_ARRAY:
        assert getattr(absent, field) == getattr(world, field)
        assert getattr(again, field) == pytest.approx(getattr(present, field), abs=1e-12)
    assert present != absent
    for c in effect.coefficients:
        if c.centre or c.kind == "linear":
            assert c.z(c.value(0.3)) == pytest.approx(0.3)
