from itertools import pairwise

import numpy as np
import pytest
from avbd_sheets import G, Run, cloth, hold, square_grid
from scipy.integrate import solve_ivp

MU, LAMBDA, DENSITY = 0.6, 0.3, 0.2
SECONDS = 0.2
FLAT, FACES = square_grid(3, 3, 0.1)
POINTS = FLAT - FLAT.mean(axis=0)
ORDERS = pytest.mark.parametrize(
    ("integrator", "low", "high"), [("implicit_euler", 0.7, 1.3), ("bdf2", 1.7, 2.3)], ids=["implicit_euler", "bdf2"]
)


def exact(mass: np.ndarray, held: np.ndarray, speed: np.ndarray, gravity: np.ndarray) -> np.ndarray:
    """Positions after `SECONDS` of the same vertices and membrane, integrated in float64 to nine digits."""
    a, b, c = (FACES[:, i] for i in range(3))
    pose = np.linalg.inv(np.stack([POINTS[b] - POINTS[a], POINTS[c] - POINTS[a]], axis=-1)[:, :2, :])
    area = 0.5 / np.abs(np.linalg.det(pose))

    def rate(_: float, state: np.ndarray) -> np.ndarray:
        x, v = state.reshape(2, -1, 3)
        stretch = np.stack([x[b] - x[a], x[c] - x[a]], axis=-1) @ pose
        strain = 0.5 * (stretch.swapaxes(1, 2) @ stretch - np.eye(2))
        stress = 2.0 * MU * strain + LAMBDA * np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(2)
        pull = -area[:, None, None] * stretch @ stress @ pose.swapaxes(1, 2)
        force = np.zeros_like(x)
        np.add.at(force, b, pull[:, :, 0])
        np.add.at(force, c, pull[:, :, 1])
        np.add.at(force, a, -pull.sum(axis=-1))
        acceleration = force / mass[:, None] + gravity
        acceleration[held] = 0.0
        return np.concatenate([v.ravel(), acceleration.ravel()])

    start = np.concatenate([POINTS.ravel(), speed.ravel()])
    end = solve_ivp(rate, (0.0, SECONDS), start, method="DOP853", rtol=1e-9, atol=1e-12)
    return end.y[: POINTS.size, -1].reshape(-1, 3)


def errors(integrator: str, held: np.ndarray, speed: np.ndarray, gravity: np.ndarray) -> np.ndarray:
    """Root mean square error [m] with 40, 80 and 160 steps."""
    model = cloth(POINTS, FACES, density=DENSITY, tri_ke=MU, tri_ka=LAMBDA, gravity=tuple(gravity))
    hold(model, held)
    truth = exact(model.particle_mass.numpy().astype(float), held, speed, gravity)
    found = []
    for steps in (40, 80, 160):
        run = Run(model, SECONDS / steps, integrator=integrator, iterations=60).put(v=speed).step(steps)
        found.append(np.sqrt(((run.x - truth) ** 2).mean()))
    return np.array(found)


def assert_order(found: np.ndarray, low: float, high: float) -> None:
    for coarse, fine in pairwise(found):
        assert low < np.log2(coarse / fine) < high


@ORDERS
def test_error_of_a_sheet_flying_apart_falls_with_the_order_of_the_integrator(integrator, low, high):
    speed = POINTS * np.array([4.0, -2.0, 0.0]) + np.cross([0.0, 0.0, 5.0], POINTS)
    assert_order(errors(integrator, np.zeros(9, dtype=bool), speed, np.zeros(3)), low, high)


@ORDERS
def test_error_of_a_sheet_let_go_under_gravity_falls_with_the_order_of_the_integrator(integrator, low, high):
    held = POINTS[:, 1] > POINTS[:, 1].max() - 1e-6
    assert_order(errors(integrator, held, np.zeros_like(POINTS), np.array([0.0, -G, 0.0])), low, high)
