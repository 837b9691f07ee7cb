import numpy as np
import pytest
from avbd_sheets import RADIUS, G, Run, cloth, square_grid

POINTS, FACES = square_grid(5, 5, 0.03)
ON_THE_GROUND = POINTS - POINTS.mean(axis=0) + np.array([0.0, 0.0, RADIUS])
DT = 1.0 / 240.0
CREEP = 2e-3
ENOUGH = 20  # iterations


def lying(mu: float, slope: float, iterations: int) -> Run:
    """A sheet on a plane that rises by `slope`, seen along the plane: gravity leans, the plane stays."""
    tilt = np.arctan(slope)
    gravity = (G * np.sin(tilt), 0.0, -G * np.cos(tilt))
    ground = {"ke": 300.0, "kd": 0.2, "mu": mu}
    model = cloth(ON_THE_GROUND, FACES, density=0.3, gravity=gravity, ground=ground)
    run = Run(model, DT, touching=True, iterations=iterations, friction_speed_m_s=CREEP)
    weight = G * np.cos(tilt) * model.particle_mass.numpy()
    sunk = ON_THE_GROUND.copy()
    sunk[:, 2] -= weight / ground["ke"]
    return run.put(x=sunk)


MU = pytest.mark.parametrize("mu", [0.2, 0.5, 1.0])
ITERATIONS = pytest.mark.parametrize("iterations", [5, ENOUGH])


@MU
@ITERATIONS
def test_below_the_angle_of_friction_a_sheet_creeps_slower_than_the_regularisation_says(mu, iterations):
    run = lying(mu, 0.98 * mu, iterations)
    speed = run.trace(120, lambda r: np.abs(r.v[:, 0]).max())
    assert speed.max() < CREEP
    assert speed[-1] == pytest.approx(speed[-60], rel=0.02)


@MU
@ITERATIONS
def test_above_the_angle_of_friction_a_sheet_slides_faster_and_faster(mu, iterations):
    speed = lying(mu, 1.02 * mu, iterations).trace(240, lambda r: r.v[:, 0].min())
    assert speed[-1] > 1.5 * speed[120] > 1.5 * CREEP


@MU
def test_a_creeping_sheet_moves_as_the_regularised_law_says(mu):
    share = 0.75  # = 2 s - s^2 at s = 1/2
    speed = lying(mu, share * mu, ENOUGH).step(60).v[:, 0]
    assert speed == pytest.approx(np.full(len(speed), 0.5 * CREEP), rel=0.02)


@MU
def test_a_sheet_slides_down_with_what_friction_leaves_of_gravity(mu):
    slope = 1.5 * mu
    speed = lying(mu, slope, ENOUGH).trace(60, lambda r: r.v[:, 0].mean())
    normal = mu * G * np.cos(np.arctan(slope))
    slowed = G * np.sin(np.arctan(slope)) - (speed[60] - speed[20]) / (40 * DT)
    assert slowed == pytest.approx(normal, rel=0.02)


@MU
def test_a_sliding_sheet_is_slowed_down_by_mu_g(mu):
    run = lying(mu, 0.0, ENOUGH).put(v=np.array([3.0, 0.0, 0.0]))
    speed = run.trace(48, lambda r: r.v[:, 0].mean())
    assert (speed[8] - speed[48]) / (40 * DT) == pytest.approx(mu * G, rel=0.02)


def test_the_sheet_rests_one_radius_above_the_ground_less_the_yield_of_its_penalty():
    run = lying(0.5, 0.0, 10).put(x=ON_THE_GROUND).step(120)
    depth = G * run.model.particle_mass.numpy() / 300.0
    assert run.x[:, 2] == pytest.approx(RADIUS - depth, abs=1e-6)
    assert np.abs(run.v).max() < 1e-4
