import numpy as np
import pytest
from avbd_sheets import G, Run, cloth, hold, square_grid, triangle_grid

WEIGHTLESS = (0.0, 0.0, 0.0)


def rolled(columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """A tube of radius 5 cm, closed around its axis like a sleeve."""
    flat, faces = square_grid(columns + 1, rows, 0.3 / columns)
    around = 2.0 * np.pi * flat[:, 0] / 0.3
    tube = np.stack([0.05 * np.cos(around), 0.05 * np.sin(around), flat[:, 1]], axis=1)
    seam = np.arange(len(tube)).reshape(rows, columns + 1)
    kept = seam[:, :-1].reshape(-1)
    renumber = np.empty(len(tube), dtype=int)
    renumber[kept] = np.arange(len(kept))
    renumber[seam[:, -1]] = renumber[seam[:, 0]]
    return tube[kept], renumber[faces]


def pleated() -> tuple[np.ndarray, np.ndarray]:
    """A strip in folds of 60 degrees, one of them turned over by more than a right angle."""
    flat, faces = square_grid(9, 4, 0.03)
    points = np.zeros_like(flat)
    direction = np.cumsum([0.0, 1.05, -1.05, 1.05, 2.0, -2.0, -1.05, 1.05])
    ends = np.concatenate([[0.0], np.cumsum(np.exp(1j * direction))]) * 0.03
    column = np.tile(np.arange(9), 4)
    points[:, 0], points[:, 1], points[:, 2] = ends[column].real, flat[:, 1], ends[column].imag
    return points, faces


SHAPES = pytest.mark.parametrize("shape", [rolled(12, 6), pleated()], ids=["sleeve", "pleats"])


@SHAPES
@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_a_shape_at_rest_that_is_not_flat_stays_as_it_is(shape, integrator):
    points, faces = shape
    model = cloth(points, faces, edge_ke=1e-2, gravity=WEIGHTLESS)
    dt, steps = 0.01, 100
    run = Run(model, dt, integrator=integrator, max_strain=0.05).step(steps)
    rounding = np.spacing(np.float32(4.0 * np.abs(points).max())) / dt  # of 3 x - 4 x1 + x2, over the step
    random_walk = 3.0 * np.sqrt(steps) * rounding
    assert np.abs(run.v).max() < random_walk
    assert np.abs(run.x - points).max() < random_walk * steps * dt
    assert distance_of_shapes(run.x, points) < 1e-6


@SHAPES
def test_a_shape_bent_away_from_rest_returns_to_it_and_not_to_flat(shape):
    points, faces = shape
    model = cloth(points, faces, edge_ke=5e-2, tri_kd=0.02, edge_kd=1e-4, gravity=WEIGHTLESS)
    crumpled = points + 0.003 * np.random.default_rng(0).standard_normal(points.shape)
    run = Run(model, 0.01, iterations=100).put(x=crumpled).step(100)
    assert distance_of_shapes(crumpled, points) > 2e-3
    assert distance_of_shapes(run.x, points) < 2e-4


def distance_of_shapes(a: np.ndarray, b: np.ndarray) -> float:
    """Root mean square distance [m] of points after the best rigid motion (Kabsch)."""
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    keep = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    return float(np.sqrt(((a @ u @ keep @ vt - b) ** 2).sum(axis=1).mean()))


def draped(fused: bool, iterations: int, steps: int) -> np.ndarray:
    points, faces = triangle_grid(0.2, 0.2, 0.05)
    model = cloth(points, faces, density=0.3, edge_ke=1e-3, tri_kd=1e-3, gravity=(0.0, 0.0, -G))
    hold(model, (points[:, 1] < 1e-6) & (np.abs(points[:, 0]) > 0.09))
    run = Run(model, 1.0 / 200.0, iterations=iterations, fused=fused, max_strain=0.05)
    return run.step(steps).x


@pytest.mark.parametrize("fused", [True, False])
def test_the_same_start_gives_the_same_bytes(fused):
    assert draped(fused, 10, 50).tobytes() == draped(fused, 10, 50).tobytes()


def test_fused_and_coloured_sweep_agree_where_both_have_converged():
    fused, coloured = (draped(fused, 500, 20) for fused in (True, False))
    start = triangle_grid(0.2, 0.2, 0.05)[0]
    assert np.abs(fused - start).max() > 0.02
    assert np.abs(fused - coloured).max() < 1e-4
