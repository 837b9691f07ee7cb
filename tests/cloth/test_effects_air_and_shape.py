"""What the cell's solver makes of effects that act through the air and in the cloth, against theory."""

from typing import Any

import numpy as np
import pytest
from avbd_sheets import G, Run, cloth, hold, make_plate, square_grid, triangle_grid
from scipy.optimize import brentq

from sim1.cloth.effects import (
    AddedMass,
    AnisotropicBending,
    BendingHysteresis,
    Effect,
    PlasticCrease,
    RestCurvature,
    Shrinkage,
    StrainStiffening,
    Wind,
)

DENSITY = 0.2
POINTS, FACES = square_grid(6, 6, 0.02)
UPRIGHT = POINTS @ np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
FREE = (0.0, 0.0, 0.0)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_air_that_is_carried_along_slows_a_falling_plate_and_not_one_that_falls_along_itself(integrator):
    added = AddedMass(mass=0.3)
    lying = Run(cloth(POINTS, FACES, density=DENSITY), 1 / 500, effects=(added,), integrator=integrator)
    upright = Run(cloth(UPRIGHT, FACES, density=DENSITY), 1 / 500, effects=(added,), integrator=integrator)
    slowed = G * DENSITY / (DENSITY + added.mass)
    assert lying.trace(50, lambda now: now.v[:, 2].mean())[-1] == pytest.approx(-slowed * 0.1, rel=0.01)
    assert upright.trace(50, lambda now: now.v[:, 2].mean())[-1] == pytest.approx(-G * 0.1, rel=0.01)


def test_a_stream_takes_a_plate_along_up_to_its_own_speed():
    wind = Wind(vx=0.1, vy=0.0, vz=2.0, c_normal=1.5)
    run = Run(cloth(POINTS, FACES, gravity=FREE, density=DENSITY), 1 / 1000, effects=(wind,))
    speed = run.trace(500, lambda now: now.v.mean(axis=0))
    rate = 0.5 * 1.2 * wind.c_normal / DENSITY  # dv/dt = rate (w - v)^2
    late = wind.vz / (1.0 + rate * wind.vz * np.arange(501) / 1000)
    assert speed[:, 2] == pytest.approx(wind.vz - late, abs=0.01 * wind.vz)
    assert np.abs(speed[:, :2]).max() < 1e-3


def test_a_sheet_that_shrank_along_its_threads_comes_to_rest_at_the_new_size():
    shrunk = Shrinkage(scale_u=0.95, scale_v=1.04)
    model = cloth(POINTS, FACES, gravity=FREE, density=DENSITY)
    run = Run(model, 1.0, effects=(shrunk,), iterations=200, warm_acceleration_g=0.0)
    for _ in range(3):
        run.put(v=np.zeros(3)).step()
    assert np.ptp(run.x, axis=0)[:2] / np.ptp(POINTS, axis=0)[:2] == pytest.approx([0.95, 1.04], rel=2e-3)
    assert run.solver.sheet.mass.numpy() == pytest.approx(model.particle_mass.numpy())
    assert model.tri_areas.numpy().sum() == pytest.approx(0.01, rel=1e-5)  # the model stays as it was given
    assert run.solver.sheet.triangle_area.numpy().sum() == pytest.approx(0.01 * 0.95 * 1.04, rel=1e-5)
    lengths = run.solver.sheet.edge_length.numpy()
    start, end = run.solver.sheet.edge.numpy().T
    assert np.linalg.norm(run.x[start] - run.x[end], axis=1) == pytest.approx(lengths, rel=3e-3)


def curvature_of(across: np.ndarray, up: np.ndarray) -> float:
    """Of the circle x^2 + z^2 = 2 x x0 + 2 z z0 + c through the points; positive where its centre lies above."""
    columns = np.stack([across, up, np.ones(len(up))], axis=1)
    (twice_x, twice_z, rest), *_ = np.linalg.lstsq(columns, across**2 + up**2)
    return float(np.sign(0.5 * twice_z - up.mean()) / np.sqrt(rest + 0.25 * (twice_x**2 + twice_z**2)))


def strip(along: int, rigidity_n_m: float = 1e-4, damping_s: float = 0.0, **world: Any) -> tuple[Any, np.ndarray]:
    """A strip of 9 cm along x or y, held at its first rows, and its points."""
    points, faces = triangle_grid(*((0.09, 0.04) if along == 0 else (0.04, 0.09)), 0.01)
    points -= points.min(axis=0)
    model = cloth(points, faces, **{"gravity": FREE, "density": DENSITY, "tri_ke": 50.0, "tri_ka": 0.0, **world})
    make_plate(model, points, faces, rigidity_n_m, damping_s)
    hold(model, points[:, along] < 0.011)
    return model, points


def bent(points: np.ndarray, along: int, curvature: float) -> np.ndarray:
    """Points of a strip on a circle."""
    angle, shape = curvature * points[:, along], points.copy()
    shape[:, along], shape[:, 2] = np.sin(angle) / curvature, (1.0 - np.cos(angle)) / curvature
    return shape


def at_rest(run: Run, along: int) -> float:
    """Curvature that the free part of a strip comes to rest with."""
    for _ in range(20):
        run.put(v=np.zeros(3)).step()
    free = run.model.particle_q.numpy()[:, along] > 0.02
    return curvature_of(run.x[free, along], run.x[free, 2])


@pytest.mark.parametrize(("along", "curvature"), [(0, 6.0), (0, -6.0), (1, 6.0)])
def test_a_strip_that_is_curled_at_rest_bends_to_that_curvature_and_side(along, curvature):
    curl = RestCurvature(kappa_u=curvature if along == 0 else 0.0, kappa_v=curvature if along == 1 else 0.0)
    run = Run(strip(along)[0], 1.0, effects=(curl,), iterations=300, warm_acceleration_g=0.0)
    assert at_rest(run, along) == pytest.approx(curvature, rel=0.05)


@pytest.mark.parametrize("along", [0, 1])
def test_a_strip_that_was_bent_beyond_yield_keeps_its_share_until_the_solver_is_reset(along):
    crease = PlasticCrease(yield_curvature=8.0, retained=0.5)
    model, points = strip(along)
    run = Run(model, 1.0, effects=(crease,), iterations=300, warm_acceleration_g=0.0)

    def kept_after(curvature: float) -> bool:
        run.put(x=bent(points, along, curvature), v=np.zeros(3)).step()
        return bool(np.abs(run.solver.memory["plastic_crease"][0].numpy()).max() > 0.0)

    assert not kept_after(6.0)
    assert kept_after(20.0)
    assert at_rest(run, along) == pytest.approx(0.5 * (20.0 - 8.0), rel=0.08)
    run.put(x=points)
    run.solver.reset(run.now)
    assert not kept_after(6.0)


@pytest.mark.parametrize("along", [0, 1])
@pytest.mark.parametrize("ratio", [0.25, 4.0])
def test_a_sheet_bends_along_each_thread_as_a_plate_of_that_rigidity(along, ratio):
    rigidity = 1e-4 * np.sqrt(ratio) ** (1 - 2 * along)

    def sag(rigidity_n_m: float, *effects: Effect) -> float:
        model, points = strip(along, rigidity_n_m, gravity=(0.0, 0.0, -0.4))
        run = Run(model, 1.0, effects=effects, iterations=300, warm_acceleration_g=0.0)
        for _ in range(60):
            run.put(v=np.zeros(3)).step()
        return -float(run.x[points[:, along] > 0.085, 2].mean())

    found = sag(1e-4, AnisotropicBending(ratio_warp_weft=ratio))
    assert found == pytest.approx(sag(rigidity), rel=0.12 if along == 0 else 0.02)  # along x, rims are jagged
    assert abs(found / sag(1e-4) - 1.0) > 0.3


@pytest.mark.parametrize("along", [0, 1])
def test_a_bent_strip_comes_to_rest_where_the_friction_of_its_yarns_holds_it(along):
    """Unloaded without swinging, Dahl's z goes from z0 as -1 + (1 + z0) exp(-(k1 - k) / k_c); it rests where D k + M z = 0."""
    start, slip, moment, rigidity = 15.0, 5.0, 6e-4, 1e-4
    friction = BendingHysteresis(moment=moment, slip_curvature=slip)
    model, points = strip(along, rigidity, damping_s=1.0)
    run = Run(model, 0.02, effects=(friction,), iterations=60)
    run.put(x=bent(points, along, start)).step(300)
    first = start / (slip + start)
    rest = brentq(
        lambda k: rigidity * k - moment * (1.0 - (1.0 + first) * np.exp(-(start - k) / slip)), -start, start - 1e-6
    )
    free = points[:, along] > 0.03
    assert curvature_of(run.x[free, along], run.x[free, 2]) == pytest.approx(rest, rel=0.04)
    assert 0.2 * start < rest < 0.5 * start


def pulled(effects: tuple, along: int) -> float:
    """Strain of a sheet that hangs from the edge across axis `along`, over its length."""
    gravity = [0.0, 0.0, 0.0]
    gravity[along] = -G
    model = cloth(POINTS, FACES, gravity=tuple(gravity), density=4.0, tri_ke=100.0, tri_ka=0.0)
    hold(model, POINTS[:, along] > 0.0999)
    run = Run(model, 10.0, effects=effects, iterations=300, warm_acceleration_g=0.0)
    for _ in range(3):
        run.put(v=np.zeros(3)).step()
    return float(-run.x[POINTS[:, along] < 1e-9, along].mean() / 0.1)


@pytest.mark.parametrize("along", [0, 1])
def test_a_modulus_that_grows_with_strain_lets_a_hanging_sheet_stretch_as_its_law_says(along):
    """Load 4 G s = C e (1 + growth e) at height s over the lower edge, C = 2 mu, e the Green strain."""
    growth = 60.0
    heights = np.linspace(0.0, 0.1, 2001)
    load = 4.0 * G * heights
    green = (np.sqrt(1.0 + 4.0 * growth * load / 200.0) - 1.0) / (2.0 * growth)
    stiffer = np.mean(np.sqrt(1.0 + 2.0 * green) - 1.0)
    plain = np.mean(np.sqrt(1.0 + 2.0 * load / 200.0) - 1.0)
    assert pulled((), along) == pytest.approx(plain, rel=0.04)
    assert pulled((StrainStiffening(growth=growth),), along) == pytest.approx(stiffer, rel=0.04)
    assert stiffer < 0.7 * plain
