import newton
import numpy as np
import pytest
import warp as wp
from avbd_sheets import DEVICE, G, Run, add_cloth, hold, square_grid

RADIUS_M = 0.02


def ball_and_sheet(
    gravity_m_s2: float, ball_height_m: float, held: bool, aside_m: float = 0.0, viscosity_n_s_m: float = 0.0
) -> tuple[Run, float]:
    """A ball of 50 g above a sheet at z = 0, `aside_m` from its middle in x and y: the run and the ball's mass."""
    points, faces = square_grid(11, 11, 0.02)
    points = points - points.mean(axis=0)
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -gravity_m_s2))
    ball = builder.add_body(xform=wp.transform((aside_m, aside_m, ball_height_m), wp.quat_identity()))
    density = 0.05 / (4 / 3 * np.pi * RADIUS_M**3)
    material = newton.ModelBuilder.ShapeConfig(density=density, ke=500.0, kd=0.0, mu=0.3, margin=0.0)
    builder.add_shape_sphere(ball, radius=RADIUS_M, cfg=material)
    add_cloth(builder, points, faces, density=1.0, tri_ke=500.0, tri_ka=500.0, tri_kd=viscosity_n_s_m)
    builder.color()
    model = builder.finalize(device=DEVICE)
    if held:
        hold(model, np.abs(points[:, :2]).max(axis=1) > 0.0999)
    run = Run(model, 1 / 960, touching=True, moves_bodies=True, iterations=10)
    return run, float(model.body_mass.numpy()[0])


def test_a_ball_that_hits_a_free_sheet_gives_it_the_momentum_that_it_loses():
    run, mass = ball_and_sheet(0.0, RADIUS_M + 0.01, held=False)
    run.now.body_qd.assign(np.array([[0.0, 0.0, -1.0, 0.0, 0.0, 0.0]], np.float32))
    run.step(60)
    ball = mass * run.now.body_qd.numpy()[0, 2]
    sheet = float(run.model.particle_mass.numpy() @ run.v[:, 2])
    assert ball > -0.9 * mass
    assert ball + sheet == pytest.approx(-mass, rel=0.02)


def test_a_ball_laid_on_a_held_sheet_comes_to_rest_in_it_and_its_weight_is_carried():
    # Over the middle of a square: from a vertex it would roll down. Without viscosity it bounces and rolls for seconds.
    run, mass = ball_and_sheet(G, RADIUS_M + 0.003, held=True, aside_m=0.01, viscosity_n_s_m=10.0)
    run.step(600)
    heights = run.trace(200, lambda now: float(now.now.body_q.numpy()[0, 2]))
    assert np.ptp(heights) < 1e-5
    assert -0.05 < heights.mean() < 0.5 * RADIUS_M  # it fell into the sheet, and not through it
    push = run.trace(100, lambda now: float(now.solver._wrench.numpy()[0, 2]))
    assert push == pytest.approx(mass * G, rel=1e-2)
    assert push.mean() == pytest.approx(mass * G, rel=1e-3)


def test_bodies_stay_where_the_caller_puts_them_unless_the_solver_is_to_move_them():
    run, _ = ball_and_sheet(G, 0.3, held=True)
    run.solver.moves_bodies = False
    start = run.now.body_q.numpy().copy()
    run.step(20)
    assert np.array_equal(run.now.body_q.numpy(), start)
