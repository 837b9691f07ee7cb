"""What the cell's solver makes of effects that act where the cloth is bent, against theory."""

from itertools import permutations
from typing import Any

import numpy as np
import pytest
from avbd_elements import fold_angle
from avbd_sheets import Run, cloth, hold, make_plate, triangle_grid
from scipy.optimize import brentq

from sim1.cloth.effects import Effect
from sim1.cloth.effects.anisotropic_bending import AnisotropicBending
from sim1.cloth.effects.bending_hysteresis import BendingHysteresis
from sim1.cloth.effects.plastic_crease import PlasticCrease
from sim1.cloth.effects.rest_curvature import RestCurvature
from sim1.cloth.effects.shrinkage import Shrinkage

DENSITY = 0.2
FREE = (0.0, 0.0, 0.0)
EDGE = 0.01
ANYWHERE = pytest.mark.parametrize("moved", [0.0, 0.1, 0.25])


def curvature_of(across: np.ndarray, up: np.ndarray) -> float:
    """Of the circle x^2 + z^2 = 2 x x0 + 2 z z0 + c through the points; positive where its centre lies above."""
    columns = np.stack([across, up, np.ones(len(up))], axis=1)
    (twice_x, twice_z, rest), *_ = np.linalg.lstsq(columns, across**2 + up**2)
    return float(np.sign(0.5 * twice_z - up.mean()) / np.sqrt(rest + 0.25 * (twice_x**2 + twice_z**2)))


def strip(
    along: int,
    rigidity_n_m: float = 1e-4,
    damping_s: float = 0.0,
    *,
    length_m: float = 0.09,
    moved: float = 0.0,
    seed: int = 0,
    size: tuple[float, float] = (1.0, 1.0),
    **world: Any,
) -> tuple[Any, np.ndarray]:
    """A strip, 4 cm wide, along x or y, held at its first rows, and its points.

    Vertices are moved in the plane by up to `moved` edges along each axis, then the whole stretched to `size`.
    """
    points, faces = triangle_grid(*((length_m, 0.04) if along == 0 else (0.04, length_m)), EDGE)
    points -= points.min(axis=0)
    held = points[:, along] < 1.1 * EDGE
    points[:, :2] += moved * EDGE * np.random.default_rng(seed).uniform(-1.0, 1.0, (len(points), 2))
    points[:, :2] *= size
    model = cloth(points, faces, **{"gravity": FREE, "density": DENSITY, "tri_ke": 50.0, "tri_ka": 0.0, **world})
    make_plate(model, points, faces, rigidity_n_m, damping_s)
    hold(model, held)
    return model, points


def bent(points: np.ndarray, along: int, curvature: float) -> np.ndarray:
    """Points of a strip on a circle."""
    angle, shape = curvature * points[:, along], points.copy()
    shape[:, along], shape[:, 2] = np.sin(angle) / curvature, (1.0 - np.cos(angle)) / curvature
    return shape


def at_rest(run: Run, along: int, steps: int = 20) -> float:
    """Curvature that the free part of a strip comes to rest with."""
    for _ in range(steps):
        run.put(v=np.zeros(3)).step()
    free = run.model.particle_q.numpy()[:, along] > 0.02
    return curvature_of(run.x[free, along], run.x[free, 2])


def moments(run: Run, angle: np.ndarray) -> np.ndarray:
    """What the hinges resist (h,) [N m] when they have these angles (h,) [rad], effects without a memory so far."""
    solver = run.solver
    for arrays in solver.memory.values():
        for array in arrays:
            array.zero_()
    solver.now.hinge_now.assign((solver.curving.rest.numpy() + angle).astype(np.float32))
    solver.curving.look(solver.sheet, solver.now, run.dt)
    for effect in solver.effects:
        effect.push(solver, run.dt)
    return solver.sheet.hinge_stiffness.numpy() * (solver.now.hinge_now.numpy() - solver.sheet.hinge_angle.numpy())


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
@ANYWHERE
def test_a_fold_that_keeps_most_of_its_curvature_stays_as_it_is(along, moved):
    model, points = strip(along, moved=moved)
    crease = PlasticCrease(yield_curvature=8.0, retained=0.8)
    run = Run(model, 1.0, effects=(crease,), iterations=300, warm_acceleration_g=0.0)
    run.put(x=bent(points, along, 20.0), v=np.zeros(3)).step()
    assert at_rest(run, along) == pytest.approx(0.8 * (20.0 - 8.0), rel=0.08)
    kept = run.solver.curving.kept.numpy()
    run.step(10)
    assert run.solver.curving.kept.numpy() == pytest.approx(kept, abs=1e-2)


@pytest.mark.parametrize("ratio", [0.25, 4.0])
@pytest.mark.parametrize("along", [0, 1])
def test_what_a_fold_keeps_is_at_rest_whatever_warp_and_weft_differ_by(along, ratio):
    """As in `sim1.cloth.precise`: B_u (kappa - kept), not B_u kappa - B kept."""
    effects = (AnisotropicBending(ratio_warp_weft=ratio), PlasticCrease(yield_curvature=8.0, retained=0.5))
    model, points = strip(along)
    run = Run(model, 1.0, effects=effects, iterations=300, warm_acceleration_g=0.0)
    run.put(x=bent(points, along, 20.0), v=np.zeros(3)).step()
    assert at_rest(run, along, 60) == pytest.approx(0.5 * (20.0 - 8.0), rel=0.02)


@pytest.mark.parametrize("along", [0, 1])
@pytest.mark.parametrize(("moved", "within"), [(0.0, 1e-3), (0.1, 2e-3), (0.25, 0.02)])
@pytest.mark.parametrize("ratio", [0.25, 4.0])
def test_a_curvature_of_the_whole_sheet_takes_the_work_of_its_direction(along, moved, within, ratio):
    run = Run(strip(along, moved=moved, length_m=0.15)[0], 1.0, effects=(AnisotropicBending(ratio_warp_weft=ratio),))
    for axis, factor in enumerate((ratio**0.5, ratio**-0.5, 1.0)):
        angle = run.solver.curving.answer_of.numpy()[:, axis]
        plain = angle @ (run.solver.curving.stiffness.numpy() * angle)
        assert angle @ moments(run, angle) == pytest.approx(factor * plain, rel=within)


BENDING = [
    (AnisotropicBending(ratio_warp_weft=0.02),),
    (AnisotropicBending(ratio_warp_weft=50.0),),
    (PlasticCrease(yield_curvature=0.5, retained=0.8),),
    (PlasticCrease(yield_curvature=0.5, retained=0.8), AnisotropicBending(ratio_warp_weft=4.0)),
]


@pytest.mark.parametrize("effects", BENDING)
@ANYWHERE
def test_no_way_of_bending_is_pushed_on_and_no_long_step_throws_back(effects, moved):
    """With T the moments that a change of angles takes, S the stiffness within a step: T and 2 S - T are positive."""
    run = Run(strip(0, length_m=0.06, moved=moved, seed=1)[0], 1.0, effects=effects)
    root = np.sqrt(run.solver.curving.stiffness.numpy().astype(float))
    far = 1e4 / root  # so that yield is nothing against it
    whole = np.stack([moments(run, column) for column in np.diag(far)], axis=1) / far
    within = np.diag(run.solver.sheet.hinge_stiffness.numpy().astype(float))
    for matrix in (whole, 2.0 * within - whole):
        matrix = matrix / root[:, None] / root
        assert np.linalg.eigvalsh(0.5 * (matrix + matrix.T)).min() > 0.05


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
    assert found == pytest.approx(sag(rigidity), rel=0.04 if along == 0 else 0.02)  # along x, rims are jagged
    assert abs(found / sag(1e-4) - 1.0) > 0.3


def slight_sag(run: Run, points: np.ndarray, along: int) -> float:
    """Of the free end under a load that hardly bends the strip, by the solver's moments; no sweeps are between [m]."""
    sheet = run.solver.sheet
    hinge, count = sheet.hinge.numpy(), len(points)
    if run.solver.curving is None:
        law = np.diag(sheet.hinge_stiffness.numpy().astype(float))
    else:
        law = np.stack([moments(run, one) for one in np.eye(len(hinge))], axis=1)
    slope, by = np.zeros((len(hinge), count)), 1e-7  # of angles over heights [rad/m]
    for row, corners in zip(slope, hinge, strict=True):
        lifted = points[corners] + by * np.eye(4)[:, :, None] * np.array([0.0, 0.0, 1.0])
        row[corners] = [fold_angle(x) / by for x in lifted]
    free = points[:, along] > 1.5 * EDGE
    load = sheet.mass.numpy().astype(float)
    down = np.zeros(count)
    down[free] = np.linalg.solve((slope.T @ law @ slope)[np.ix_(free, free)], load[free])
    return float(down[points[:, along] > points[:, along].max() - 0.3 * EDGE].mean())


@pytest.mark.parametrize("along", [0, 1])
@pytest.mark.parametrize("moved", [0.0, 0.1])
@pytest.mark.parametrize("ratio", [0.25, 4.0])
def test_a_load_bends_a_long_strip_as_one_of_the_rigidity_along_it(along, moved, ratio):
    rigidity = 1e-4 * np.sqrt(ratio) ** (1 - 2 * along)
    model, points = strip(along, 1e-4, length_m=0.15, moved=moved)
    plain, _ = strip(along, rigidity, length_m=0.15, moved=moved)
    woven = Run(model, 1.0, effects=(AnisotropicBending(ratio_warp_weft=ratio),))
    assert slight_sag(woven, points, along) == pytest.approx(slight_sag(Run(plain, 1.0), points, along), rel=0.03)


@pytest.mark.parametrize("along", [0, 1])
@pytest.mark.parametrize("ratio", [1.0, 4.0])
def test_a_strip_creeps_back_by_its_damping_time_whatever_warp_and_weft_differ_by(along, ratio):
    """Kelvin-Voigt with B_u and tau B_u, heavily damped: the curvature falls as exp(-t / tau)."""
    model, points = strip(along, 1e-4, damping_s=1.0, density=0.02)
    run = Run(model, 0.01, effects=(AnisotropicBending(ratio_warp_weft=ratio),), iterations=300)
    run.put(x=bent(points, along, 8.0)).step(50)
    free = points[:, along] > 0.03
    assert curvature_of(run.x[free, along], run.x[free, 2]) == pytest.approx(8.0 * np.exp(-0.5), rel=0.06)


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


def test_a_sheet_that_shrank_bends_as_one_that_was_made_in_that_size():
    """Its hinges, their angles at rest and its curvature; mass is kept, which bending does not ask for."""
    size = (0.9, 1.1)
    others = (
        AnisotropicBending(ratio_warp_weft=4.0),
        BendingHysteresis(moment=1e-4, slip_curvature=4.0),
        PlasticCrease(yield_curvature=8.0, retained=0.5),
        RestCurvature(kappa_u=2.0, kappa_v=-3.0),
    )
    shrunk = Run(strip(0, moved=0.1)[0], 1.0, effects=(*others, Shrinkage(scale_u=size[0], scale_v=size[1])))
    small = Run(strip(0, moved=0.1, size=size)[0], 1.0, effects=others)
    for name in ("hinge_stiffness", "hinge_angle", "hinge_damping"):
        expected = getattr(small.solver.sheet, name).numpy()
        assert getattr(shrunk.solver.sheet, name).numpy() == pytest.approx(expected, rel=1e-4)
    for name in ("answer_of", "start", "end", "stiffness", "split", "rest"):
        expected = getattr(small.solver.curving, name).numpy()
        far = float(np.abs(expected).max())
        assert getattr(shrunk.solver.curving, name).numpy() == pytest.approx(expected, rel=1e-4, abs=1e-4 * far)


def test_the_order_in_which_effects_are_given_says_nothing():
    effects = (
        Shrinkage(scale_u=0.95, scale_v=1.02),
        PlasticCrease(yield_curvature=4.0, retained=0.5),
        AnisotropicBending(ratio_warp_weft=3.0),
        BendingHysteresis(moment=1e-4, slip_curvature=4.0),
    )
    ends = set()
    for order in permutations(effects):
        model, points = strip(0, 1e-5, gravity=(0.0, 0.0, -9.81))
        ends.add(Run(model, 0.01, effects=order).put(x=bent(points, 0, 20.0)).step(3).x.tobytes())
    assert len(ends) == 1
