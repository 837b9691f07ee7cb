"""The virtual laboratory against closed formulas."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.concealed.bending import Plate, add_moments, curvatures
from benchmarks.concealed.cloth import Cloth, Grid, grid_of
from benchmarks.concealed.membrane import Membrane
from benchmarks.concealed.sheet import baseline_sheet, clamped, stable_step_s
from benchmarks.concealed.table import Contact, Friction

CLOTH = Cloth(0.3, 0.3, 0.2, 0.001, 300.0, 0.0, 1e-4, 1e-3)
NO_TABLE = Friction(0.0, 0.0)


class Bench:
    """A sheet without a recording around it: x and v (3, count), some vertices held where they are."""

    def __init__(
        self, cloth: Cloth, columns: int, rows: int, held=(), friction: Friction | None = None, damping_s=None
    ):
        self.grid = grid_of(cloth, columns, rows, 1)
        self.held = np.array(held, dtype=int)
        sheet = baseline_sheet(cloth, self.grid)
        self.sheet = clamped(sheet, self.held) if len(self.held) else sheet
        self.membrane = Membrane(self.sheet, self.held, damping_s)
        self.plate = Plate(self.sheet, damping_s)
        level = None if friction is None else 0.0
        self.contact = Contact(self.grid.count, level, friction or NO_TABLE, friction.mu_x if friction else 0.0)
        self.x = np.zeros((3, self.grid.count))
        self.x[:2, self.grid.inside] = self.grid.uv_m.T
        self.v = np.zeros_like(self.x)
        self.inner = stable_step_s(self.sheet, cloth.damping_s if damping_s is None else damping_s)

    def run(self, duration_s: float, gravity=(0.0, 0.0, 0.0), decay_per_s: float = 0.0, watch=None) -> list:
        number = max(1, int(1e-4 / self.inner))
        steps = int(np.ceil(duration_s / (number * self.inner)))
        step = duration_s / steps
        slow = np.zeros_like(self.x)
        keep = float(np.exp(-decay_per_s * step / number))
        seen = []
        for _ in range(steps):
            slow[:] = np.array(gravity)[:, None] * self.sheet.mass_kg
            self.plate.add(self.x, self.v, slow)
            self.membrane.step(self.x, self.v, slow, step / number, number, self.contact, keep)
            if watch:
                seen.append(watch())
        return seen

    def energy_j(self, gravity=(0.0, 0.0, 0.0)) -> float:
        return kinetic_j(self) + stored_j(self) - float((np.array(gravity) @ self.x) @ self.sheet.mass_kg)


def kinetic_j(bench: Bench) -> float:
    return float(0.5 * (bench.sheet.mass_kg * (bench.v**2).sum(axis=0)).sum())


def stored_j(bench: Bench) -> float:
    """Elastic energy from the definitions, cell by cell."""
    sheet, grid = bench.sheet, bench.grid
    x = bench.x[:, grid.inside].reshape(3, grid.rows, grid.columns)

    def cells(a):
        return a[grid.inside].reshape(grid.rows, grid.columns)[:-1, :-1]

    du, dv = np.diff(x, axis=2) / grid.du_m, np.diff(x, axis=1) / grid.dv_m
    eu, ev = ((du**2).sum(axis=0) - 1) / 2, ((dv**2).sum(axis=0) - 1) / 2
    shear = ((du[:, 1:] + du[:, :-1]) * (dv[:, :, 1:] + dv[:, :, :-1])).sum(axis=0) / 4
    energy = (
        cells(sheet.uu_j) * (eu[1:] ** 2 + eu[:-1] ** 2) / 4
        + cells(sheet.vv_j) * (ev[:, 1:] ** 2 + ev[:, :-1] ** 2) / 4
        + cells(sheet.uv_j) * (eu[1:] + eu[:-1]) * (ev[:, 1:] + ev[:, :-1]) / 4
        + cells(sheet.shear_j) * shear**2 / 2
    ).sum()
    uu, vv = np.diff(x, 2, axis=2) / grid.du_m**2, np.diff(x, 2, axis=1) / grid.dv_m**2
    uv = np.diff(np.diff(x, axis=1), axis=2) / (grid.du_m * grid.dv_m)
    bend_u = sheet.bend_u_n_m3[grid.inside].reshape(grid.rows, grid.columns)[:, 1:-1]
    bend_v = sheet.bend_v_n_m3[grid.inside].reshape(grid.rows, grid.columns)[1:-1]
    energy += (bend_u * (uu**2).sum(axis=0)).sum() / 2 + (bend_v * (vv**2).sum(axis=0)).sum() / 2
    return float(energy + (cells(sheet.twist_n_m3) * (uv**2).sum(axis=0)).sum())


def crumpled(bench: Bench, rng: np.random.Generator, size_m: float = 0.004) -> None:
    bench.x[:, bench.grid.inside] += rng.normal(0, size_m, (3, len(bench.grid.inside)))
    bench.v[:, bench.grid.inside] = rng.normal(0, 0.3, (3, len(bench.grid.inside)))


def test_forces_are_the_slope_of_the_energy_and_damping_only_dissipates():
    cloth = replace(CLOTH, poisson=0.3)
    bench = Bench(cloth, 6, 7)
    rng = np.random.default_rng(0)
    crumpled(bench, rng)
    still = np.zeros_like(bench.v)
    force = bench.membrane.forces(bench.x, still)
    bench.plate.add(bench.x, still, force)
    way = np.zeros_like(bench.x)
    way[:, bench.grid.inside] = rng.normal(size=(3, len(bench.grid.inside)))
    at, small = bench.x.copy(), 1e-7
    bench.x = at + small * way
    after = stored_j(bench)
    bench.x = at - small * way
    before = stored_j(bench)
    bench.x = at
    assert -(force * way).sum() == pytest.approx((after - before) / (2 * small), rel=1e-6)
    damped = bench.membrane.forces(bench.x, bench.v)
    bench.plate.add(bench.x, bench.v, damped)
    assert ((damped - force) * bench.v).sum() < 0


def test_forces_have_no_resultant_and_no_torque_and_do_not_damp_a_turning_sheet():
    bench = Bench(replace(CLOTH, poisson=0.3), 6, 7)
    crumpled(bench, np.random.default_rng(1))
    size = (bench.grid.rows, bench.grid.columns, bench.grid.du_m, bench.grid.dv_m)
    normal, kappa = np.zeros_like(bench.x), np.zeros((2, bench.grid.count))
    curvatures(bench.x, *size, normal, kappa)
    moments = np.zeros_like(bench.x)
    add_moments(bench.x, np.sign(kappa) * 1e-6, *size, normal, moments)
    stretch = bench.membrane.forces(bench.x, bench.v)
    plate = np.zeros_like(bench.x)
    bench.plate.add(bench.x, 0 * bench.v, plate)
    for force in (moments, stretch, plate):
        assert np.abs(force.sum(axis=1)).max() < 1e-10 * np.abs(force).max()
        assert np.abs(np.cross(bench.x.T, force.T).sum(axis=0)).max() < 1e-10 * np.abs(force).max()
    turning = np.zeros_like(bench.v)
    turning[:, bench.grid.inside] = np.cross([1.0, 2.0, 3.0], bench.x[:, bench.grid.inside].T).T
    smooth = Bench(CLOTH, 6, 7)
    u, v = smooth.grid.flat_uv_m.T
    smooth.x[:, smooth.grid.inside] = np.stack([np.sin(3 * u) / 3, v, (1 - np.cos(3 * u)) / 3])[:, smooth.grid.inside]
    spin = np.zeros_like(smooth.v)
    spin[:, smooth.grid.inside] = np.cross([1.0, 2.0, 3.0], smooth.x[:, smooth.grid.inside].T).T
    still, moving = np.zeros_like(plate), np.zeros_like(plate)
    smooth.plate.add(smooth.x, 0 * spin, still)
    smooth.plate.add(smooth.x, spin, moving)
    assert np.abs(moving - still).max() < 1e-3 * np.abs(still).max()
    assert bench.membrane.forces(bench.x, turning) == pytest.approx(
        bench.membrane.forces(bench.x, 0 * turning), abs=1e-9
    )


@pytest.mark.parametrize("angle_deg", [0.0, 30.0])
def test_uniform_stretch_gives_the_stress_of_plane_stress_in_any_direction(angle_deg):
    cloth = replace(CLOTH, poisson=0.3)
    bench = Bench(cloth, 8, 8)
    turn = Rotation.from_euler("z", angle_deg, degrees=True).as_matrix()[:2, :2]
    strain = 1e-4
    stretch = turn @ np.diag([1 + strain, 1 - 0.3 * strain]) @ turn.T
    bench.x[:2, bench.grid.inside] = stretch @ bench.grid.uv_m.T
    energy = stored_j(bench)
    assert energy == pytest.approx(0.5 * 300 * strain**2 * 0.09, rel=1e-3)
    force = bench.membrane.forces(bench.x, bench.v)
    inner = bench.grid.inside.reshape(8, 8)[1:-1, 1:-1]
    assert np.abs(force[:, inner]).max() < 1e-9


def test_free_fall():
    bench = Bench(CLOTH, 7, 7)
    bench.inner *= 0.2
    bench.run(0.2, (0.0, 0.0, -9.81))
    assert bench.x[2, bench.grid.inside] == pytest.approx(-0.5 * 9.81 * 0.04, rel=2e-3)


def test_hanging_sheet_grows_by_its_weight():
    grid = grid_of(CLOTH, 9, 9, 1)
    bench = Bench(CLOTH, 9, 9, held=grid.inside[:9], damping_s=5e-5)
    bench.run(0.8, (0.0, 9.81, 0.0), decay_per_s=40.0)
    grown = bench.x[1, bench.grid.inside[-9:]] - 0.3
    assert grown == pytest.approx(0.2 * 9.81 * 0.3**2 / (2 * 300), rel=0.02)


@pytest.mark.parametrize("along", ["u", "v"])
def test_cantilever_sags_as_a_beam(along):
    """Weak gravity: tip w = rho g L^4 / (8 B), with L from the edge of the clamp."""
    columns, rows = (17, 5) if along == "u" else (5, 17)
    cloth = replace(CLOTH, size_u_m=0.16 if along == "u" else 0.04, size_v_m=0.04 if along == "u" else 0.16)
    grid = grid_of(cloth, columns, rows, 1)
    net = grid.inside.reshape(rows, columns)
    held = (net[:, :2] if along == "u" else net[:2]).ravel()
    bench = Bench(cloth, columns, rows, held=held, damping_s=5e-5)
    gravity = 0.03
    bench.run(6.0, (0.0, 0.0, -gravity), decay_per_s=4.0)
    tip = bench.x[2, net[:, -1] if along == "u" else net[-1]]
    assert tip == pytest.approx(-0.2 * gravity * 0.15**4 / (8 * 1e-4), rel=0.03)


def test_sheet_on_a_pin_swings_in_its_plane_as_a_rigid_pendulum():
    """Held at a corner: T = 2 pi sqrt(I / (m g d)), I = 2/3 m a^2, d = a / sqrt 2."""
    cloth = replace(CLOTH, size_u_m=0.2, size_v_m=0.2)
    grid = grid_of(cloth, 7, 7, 1)
    bench = Bench(cloth, 7, 7, held=[grid.at(0, 0)])
    down = Rotation.from_euler("z", -45 - 5, degrees=True).as_matrix()
    bench.x[:, grid.inside] = down @ np.vstack([grid.uv_m.T, np.zeros(len(grid.uv_m))])
    last = grid.at(6, 6)
    seen = bench.run(1.2, (9.81, 0.0, 0.0), watch=lambda: bench.x[1, last])
    crossings = np.flatnonzero(np.diff(np.sign(seen)))
    period = 2 * (crossings[1] - crossings[0]) * 1.2 / len(seen)
    assert period == pytest.approx(2 * np.pi * np.sqrt(2 / 3 * 0.2 / (9.81 / np.sqrt(2))), rel=0.01)


def test_limp_sheet_swings_as_a_hanging_chain():
    """First frequency of a chain: 1.2024 sqrt(g / L)."""
    cloth = replace(CLOTH, size_u_m=0.05, bending_n_m=1e-7)
    grid = grid_of(cloth, 3, 25, 1)
    bench = Bench(cloth, 3, 25, held=grid.inside[:3])
    bench.x[2, grid.inside] = 0.02 * (grid.uv_m[:, 1] / 0.3) ** 1.5
    seen = bench.run(1.3, (0.0, 9.81, 0.0), watch=lambda: bench.x[2, grid.at(12, 1)])
    crossings = np.flatnonzero(np.diff(np.sign(seen)))
    half = (crossings[-1] - crossings[0]) / (len(crossings) - 1) * 1.3 / len(seen)
    assert np.pi / half == pytest.approx(1.2024 * np.sqrt(9.81 / 0.3), rel=0.04)


def test_energy_stays_without_damping_and_falls_with_it():
    for damping, low, high in ((0.0, 0.995, 1.005), (1e-3, 0.0, 0.95)):
        bench = Bench(replace(CLOTH, damping_s=damping, poisson=0.3), 7, 7, damping_s=damping)
        u, v = bench.grid.flat_uv_m.T
        bench.v[2, bench.grid.inside] = (np.sin(20 * u) * np.cos(17 * v))[bench.grid.inside]
        bench.inner *= 0.2
        first = bench.energy_j()
        for _ in range(3):
            bench.run(0.1)
            assert low <= bench.energy_j() / first <= high


def test_sliding_sheet_stops_after_the_way_of_coulomb_and_a_stuck_one_stays():
    bench = Bench(CLOTH, 5, 5, friction=Friction(0.4, 0.4))
    bench.inner *= 0.2
    bench.v[0, bench.grid.inside] = 0.5
    start = bench.x[0].copy()
    bench.run(0.3, (0.0, 0.0, -9.81))
    way = (bench.x[0] - start)[bench.grid.inside]
    assert way == pytest.approx(0.5**2 / (2 * 0.4 * 9.81), rel=5e-3)
    assert np.abs(bench.v).max() < 1e-12
    bench.run(0.1, (9.81 * 0.39, 0.0, -9.81))
    assert (bench.x[0] - start)[bench.grid.inside] == pytest.approx(way, abs=1e-12)
    bench.run(0.1, (9.81 * 0.5, 0.0, -9.81))
    assert (bench.x[0] - start)[bench.grid.inside] - way == pytest.approx(0.5 * 9.81 * 0.1 * 0.01, rel=0.02)


def test_friction_laws_stick_longer_and_slide_along_the_ellipse():
    sticky = Bench(CLOTH, 4, 4, friction=Friction(0.4, 0.4, static_ratio=1.5))
    sticky.inner *= 0.02  # a step gains little speed against that over which friction falls
    sticky.run(0.05, (9.81 * 0.55, 0.0, -9.81))
    assert np.abs(sticky.v).max() < 1e-12
    sticky.run(0.05, (9.81 * 0.65, 0.0, -9.81))
    late = 0.005 * np.log(0.25 / 0.05)  # friction that falls by exp(-v / 5 mm/s) from 0.6 to 0.4, integrated
    assert sticky.v[0, sticky.grid.inside] == pytest.approx(9.81 * 0.25 * 0.05 - late, rel=0.02)
    oval = Bench(CLOTH, 4, 4, friction=Friction(0.6, 0.3))
    oval.v[:2, oval.grid.inside] = 0.5
    oval.run(0.001, (0.0, 0.0, -9.81))
    lost = 0.5 - oval.v[:2, oval.grid.inside].mean(axis=1)
    assert lost[0] / lost[1] == pytest.approx(4.0, rel=0.02)
    assert (lost[0] / 0.6) ** 2 + (lost[1] / 0.3) ** 2 == pytest.approx((9.81 * 0.001) ** 2, rel=0.02)


def test_friction_by_the_baselines_law_lacks_no_force_at_all_and_any_other_does():
    def missing(friction):
        bench = Bench(CLOTH, 4, 4, friction=friction)
        bench.v[0, bench.grid.inside], bench.v[1, bench.grid.inside] = 0.5, 0.2
        bench.run(0.01, (1.0, 0.5, -9.81))
        lacking, pressed = bench.contact.take_impulses()
        assert pressed.max() > 0
        return np.abs(lacking).max()

    assert missing(Friction(0.4, 0.4)) == 0
    for other in (Friction(0.4, 0.3), Friction(0.4, 0.4, static_ratio=1.5, stribeck_speed_m_s=0.3)):
        assert missing(other) > 1e-9


def test_step_is_just_stable():
    """The bound on the step holds for the true highest frequency, and is not far from it."""
    for damping in (0.0, 1e-3):
        bench = Bench(replace(CLOTH, poisson=0.3), 8, 8, damping_s=damping)
        x, mass = bench.x.copy(), np.where(bench.sheet.mass_kg > 0, bench.sheet.mass_kg, 1)
        undamped = Membrane(bench.sheet, bench.held, 0.0)
        way = np.zeros_like(x)
        way[:, bench.grid.inside] = np.random.default_rng(0).normal(size=(3, len(bench.grid.inside)))
        for _ in range(300):
            pull = (undamped.forces(x - 1e-7 * way, 0 * x) - undamped.forces(x + 1e-7 * way, 0 * x)) / 2e-7 / mass
            square = np.linalg.norm(pull) / np.linalg.norm(way)
            way = pull / np.linalg.norm(pull)
        zeta = damping * np.sqrt(square) / 2
        limit = 2 / np.sqrt(square) * (np.sqrt(1 + zeta**2) - zeta)
        assert 0.5 < bench.inner / limit < 0.95


def test_grid_areas_add_up():
    grid = Grid(4, 3, 0.1, 0.2)
    assert grid.area_m2.sum() == pytest.approx(0.3 * 0.4)
    assert grid.area_m2[grid.at(0, 0)] == pytest.approx(0.005)
    assert grid.area_m2[grid.at(1, 1)] == pytest.approx(0.02)
