import numpy as np
import pytest
from avbd_sheets import Run, cloth, hold, square_grid

from sim1.cloth.avbd import SelfContact
from sim1.validity.penetration import crossings

LAYERS = SelfContact(radius_m=0.003, search_m=0.006, stiffness_n_m=200.0, damping_n_s_m=0.0)


def two_sheets(gap_m: float, count: int = 9) -> tuple[np.ndarray, np.ndarray]:
    """Two sheets of 16 cm one above the other, the upper one turned by 20 degrees."""
    points, faces = square_grid(count, count, 0.02)
    points = points - points.mean(axis=0)
    c, s = np.cos(0.35), np.sin(0.35)
    upper = points @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) * 0.7 + np.array([0.0, 0.0, gap_m])
    return np.concatenate([points, upper]), np.concatenate([faces, faces + len(points)])


def test_the_counter_of_crossings_sees_a_sheet_that_cuts_another():
    points, faces = two_sheets(0.01)
    assert len(crossings(points, faces)) == 0
    points[len(points) // 2 :, 2] += np.linspace(-0.05, 0.05, len(points) // 2)
    assert len(crossings(points, faces)) > 5


@pytest.mark.parametrize("speed_m_s", [0.5, 5.0])
def test_a_sheet_thrown_on_a_held_one_does_not_pass_through_it(speed_m_s):
    points, faces = two_sheets(0.02)
    model = cloth(points, faces)
    half = len(points) // 2
    hold(model, np.arange(half)[np.abs(points[:half, :2]).max(axis=1) > 0.0799])
    run = Run(model, 1 / 240, self_contact=LAYERS, max_strain=0.05, iterations=5)
    speed = np.zeros_like(points)
    speed[half:, 2] = -speed_m_s
    run.put(v=speed)
    for _ in range(60):
        run.step()
        assert len(crossings(run.x, faces)) == 0
    assert run.x[half:, 2].mean() > run.x[:half, 2].mean()
    assert run.solver.broken() is None


def test_layers_that_travel_together_are_not_braked_by_their_nearness():
    points, faces = two_sheets(0.0005)
    soft = SelfContact(radius_m=0.003, search_m=0.006, stiffness_n_m=0.0)  # nothing pushes, only passing is forbidden
    run = Run(cloth(points, faces, gravity=(0.0, 0.0, 0.0)), 1 / 240, self_contact=soft, iterations=5)
    direction = np.array([1.0, 0.5, 2.0])
    run.put(v=direction)
    start = run.x.mean(axis=0)
    run.step(48)
    assert run.x.mean(axis=0) - start == pytest.approx(0.2 * direction, rel=1e-3)


def test_layers_rest_one_radius_apart_and_slide_on_each_other_with_their_own_friction():
    points, faces = two_sheets(0.003, count=7)
    half = len(points) // 2
    model = cloth(points, faces, ground={"ke": 300.0, "kd": 0.2, "mu": 5.0})
    layers = SelfContact(radius_m=0.003, search_m=0.006, stiffness_n_m=200.0, damping_n_s_m=0.05, friction=0.3)
    run = Run(model, 1 / 480, touching=True, self_contact=layers, iterations=20)
    lifted = points + np.array([0.0, 0.0, 0.002])
    run.put(x=lifted).step(60)
    gap = run.x[half:, 2].mean() - run.x[:half, 2].mean()
    assert gap == pytest.approx(layers.radius_m, abs=2e-4)
    speed = np.zeros_like(points)
    speed[half:, 0] = 0.5
    run.put(v=speed)
    speeds = run.trace(24, lambda now: now.v[half:, 0].mean())
    assert (speeds[8] - speeds[-1]) / (16 / 480) == pytest.approx(0.3 * 9.81, rel=0.15)


def test_too_many_pairs_are_an_error_that_names_the_remedy():
    points, faces = two_sheets(0.001)
    few = SelfContact(radius_m=0.003, search_m=0.006, capacity_per_vertex=1)
    run = Run(cloth(points, faces), 1 / 240, self_contact=few)
    run.step()
    with pytest.raises(RuntimeError, match="capacity_per_vertex"):
        run.solver.broken()
