import numpy as np
import pytest
from avbd_sheets import G, Run, cloth, edge_stretch, hold, square_grid, triangle_grid

POINTS, FACES = square_grid(4, 4, 0.05)
THROWN = np.array([0.3, 0.0, 1.0])
DT, STEPS = 0.01, 30
TIMES = DT * np.arange(STEPS + 1)[:, None, None]
STRONG = {
    "tri_kd": 0.5,
    "edge_kd": 1e-3,
}  # makes 2 N/m of stress per 1/s of strain; the sheet's own stretch modes die in a cycle
DAMPING = pytest.mark.parametrize("damping", [{}, STRONG], ids=["elastic", "damped"])
INTEGRATOR = pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])


def parabola() -> np.ndarray:
    return POINTS + TIMES * THROWN + 0.5 * TIMES**2 * np.array([0.0, 0.0, -G])


def flight(iterations: int, integrator: str, **damping: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities of a thrown sheet, (steps + 1, v, 3)."""
    run = Run(cloth(POINTS, FACES, **damping), DT, iterations=iterations, integrator=integrator).put(v=THROWN)
    states = run.trace(STEPS, lambda r: (r.x, r.v))
    return states[:, 0], states[:, 1]


def spin(run: Run) -> float:
    """Size of the angular momentum [kg m2/s] about the centre of mass."""
    mass = run.model.particle_mass.numpy().astype(float)[:, None]
    arm = run.x - (mass * run.x).sum(axis=0) / mass.sum()
    return float(np.linalg.norm((mass * np.cross(arm, run.v)).sum(axis=0)))


@DAMPING
def test_free_fall_is_the_discrete_solution_of_implicit_euler(damping):
    x, _ = flight(1000, "implicit_euler", **damping)
    half_a_step_ahead = 0.5 * TIMES * DT * np.array([0.0, 0.0, -G])
    assert np.abs(x - parabola() - half_a_step_ahead).max() < 2e-5


@DAMPING
def test_free_fall_is_exact_with_the_ten_iterations_of_the_preset(damping):
    x, _ = flight(10, "implicit_euler", **damping)
    half_a_step_ahead = 0.5 * TIMES * DT * np.array([0.0, 0.0, -G])
    assert np.abs(x - parabola() - half_a_step_ahead).max() < 2e-5


@DAMPING
def test_free_fall_obeys_the_difference_equation_of_bdf2(damping):
    x, v = flight(1000, "bdf2", **damping)
    rate_of_x = (3.0 * x[2:] - 4.0 * x[1:-1] + x[:-2]) / (2.0 * DT)
    rate_of_v = (3.0 * v[2:] - 4.0 * v[1:-1] + v[:-2]) / (2.0 * DT)
    assert rate_of_x == pytest.approx(v[2:], abs=1e-4)
    assert rate_of_v[5:].mean(axis=0) == pytest.approx(np.broadcast_to([0.0, 0.0, -G], POINTS.shape), abs=0.02)


def test_free_fall_of_bdf2_departs_from_the_parabola_by_no_more_than_a_start_by_implicit_euler_costs():
    x, _ = flight(1000, "bdf2")
    start_by_implicit_euler = 0.75 * G * DT**2  # its first step is g dt^2 / 2 off; BDF2 then carries 3/2 of that along
    assert np.abs(x - parabola()).max() < 1.05 * start_by_implicit_euler


@INTEGRATOR
@DAMPING
def test_translation_stays_as_it_is(integrator, damping):
    model = cloth(POINTS, FACES, gravity=(0.0, 0.0, 0.0), **damping)
    run = Run(model, DT, iterations=10, integrator=integrator).put(v=THROWN).step(STEPS)
    assert run.v == pytest.approx(np.broadcast_to(THROWN, POINTS.shape), abs=2e-4)
    assert run.x == pytest.approx(POINTS + STEPS * DT * THROWN, abs=1e-5)


@INTEGRATOR
def test_a_spinning_sheet_loses_no_more_angular_momentum_with_damping_than_the_integrator_takes_alone(integrator):
    points, faces = square_grid(3, 3, 0.05)
    points = points - points.mean(axis=0)  # about the origin, where float32 is finest
    turning = np.cross([1.8, 0.0, 2.4], points)
    lost = {}
    for name, damping in (("elastic", {}), ("damped", STRONG)):
        model = cloth(points, faces, gravity=(0.0, 0.0, 0.0), **damping)
        run = Run(model, DT, iterations=1000, integrator=integrator).put(v=turning)
        left = run.trace(50, spin)
        lost[name] = 1.0 - left[-1] / left[0]
    assert lost["damped"] == pytest.approx(lost["elastic"], abs=1e-3)
    assert 0.0 < lost["elastic"] < 1.2 * (1.0 - (1.0 + (3.0 * DT) ** 2) ** -50)


def test_the_same_damping_stops_a_vibration():
    stretching = 0.5 * (POINTS - POINTS.mean(axis=0)) * np.array([1.0, -1.0, 0.0])
    left = []
    for damping in ({}, STRONG):
        model = cloth(POINTS, FACES, gravity=(0.0, 0.0, 0.0), **damping)
        run = Run(model, 2e-4, iterations=200, integrator="bdf2").put(v=stretching)
        left.append(run.trace(150, lambda r: np.abs(edge_stretch(r.model, r.x) - 1.0).max())[100:].max())
    assert left[1] < 0.1 * left[0]


class Pendulum:
    """A stiff strip held along its upper edge; it swings out of its plane as a rigid body."""

    def __init__(self) -> None:
        flat, self.faces = triangle_grid(0.1, 0.3, 0.1)
        self.points = np.stack([flat[:, 0], 0.0 * flat[:, 0], -flat[:, 1]], axis=1)
        self.start_angle = 0.1

    def swing(self, integrator: str, dt: float, steps: int) -> np.ndarray:
        """Angle of the lowest row over time, (steps + 1,)."""
        model = cloth(self.points, self.faces, density=0.2, tri_ke=1e3, tri_ka=0.0, edge_ke=5.0)
        hold(model, self.points[:, 2] > -1e-6)
        tilt = np.array([[1, 0, 0], [0, np.cos(self.start_angle), -np.sin(self.start_angle)], [0, 0, 0]])
        tilt[2] = 0.0, np.sin(self.start_angle), np.cos(self.start_angle)
        run = Run(model, dt, iterations=400, integrator=integrator).put(x=self.points @ tilt.T)
        low = self.points[:, 2] < self.points[:, 2].min() + 1e-6
        return run.trace(steps, lambda r: np.arctan2(r.x[low, 1].mean(), -r.x[low, 2].mean()))

    def period(self) -> float:
        """2 pi sqrt(I / (m g d)) with the masses of the model's vertices, and the first term of the finite angle."""
        mass = cloth(self.points, self.faces, density=0.2).particle_mass.numpy().astype(float)
        depth = -self.points[:, 2]
        small = 2.0 * np.pi * np.sqrt((mass * depth**2).sum() / (G * (mass * depth).sum()))
        return float(small * (1.0 + self.start_angle**2 / 16.0))


def swings_back(angle: np.ndarray, dt: float) -> np.ndarray:
    """Times of the zeros of the angle."""
    before = np.flatnonzero(angle[:-1] * angle[1:] < 0.0)
    return dt * (before + angle[before] / (angle[before] - angle[before + 1]))


def test_a_stiff_hanging_sheet_swings_with_the_period_of_a_compound_pendulum():
    pendulum, dt = Pendulum(), 1.0 / 200.0
    zeros = swings_back(pendulum.swing("bdf2", dt, 400), dt)
    assert 2.0 * np.diff(zeros).mean() == pytest.approx(pendulum.period(), rel=0.01)


def test_implicit_euler_takes_the_amplitude_that_theory_says_and_bdf2_keeps_it():
    pendulum, dt, steps = Pendulum(), 1.0 / 200.0, 400
    omega = 2.0 * np.pi / pendulum.period()
    kept = {}
    for name in ("implicit_euler", "bdf2"):
        angle = np.abs(pendulum.swing(name, dt, steps))
        window = steps - round(pendulum.period() / dt)
        peak = window + int(angle[window:].argmax())
        kept[name] = angle[peak] / pendulum.start_angle
        if name == "implicit_euler":
            assert kept[name] == pytest.approx((1.0 + (omega * dt) ** 2) ** (-0.5 * peak), rel=0.02)
    assert kept["bdf2"] == pytest.approx(1.0, abs=0.01)
    assert kept["implicit_euler"] < 0.9 * kept["bdf2"]
