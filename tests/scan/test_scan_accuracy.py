"""Distances between surfaces whose distances are known."""

import numpy as np
import pytest

from sim1.scan.accuracy import deviations, samples_on
from sim1.scan.cloud import Shape

SIDE_M = 0.1
UP = np.array([0.0, 0.0, 1.0])


def rectangle(x0_m: float, x1_m: float, z_m: float = 0.0, squares: int = 1) -> Shape:
    """A rectangle of `SIDE_M` in y over x0 to x1, cut into so many squares along either side."""
    x, y = np.meshgrid(np.linspace(x0_m, x1_m, squares + 1), np.linspace(0, SIDE_M, squares + 1), indexing="ij")
    corner = (np.arange(squares)[:, None] * (squares + 1) + np.arange(squares)).ravel()
    low = np.stack([corner, corner + squares + 1, corner + 1], axis=1)
    high = np.stack([corner + 1, corner + squares + 1, corner + squares + 2], axis=1)
    return Shape(
        vertices_m=np.stack([x.ravel(), y.ravel(), np.full(x.size, z_m)], axis=1), faces=np.concatenate([low, high])
    )


def both(one: Shape, other: Shape) -> Shape:
    return Shape(
        vertices_m=np.concatenate([one.vertices_m, other.vertices_m]),
        faces=np.concatenate([one.faces, other.faces + len(one.vertices_m)]),
    )


def figures(mesh: Shape, points: np.ndarray, truth: Shape | None) -> tuple[dict[str, dict[str, float]], np.ndarray]:
    return deviations(mesh, points, np.tile(UP, (len(points), 1)), truth, np.random.default_rng(0))


@pytest.mark.parametrize("apart_m", [3e-4, -3e-4])
def test_two_parallel_squares_are_as_far_from_each_other_as_they_were_put_in_every_figure(apart_m):
    truth, mesh = rectangle(0, SIDE_M, squares=10), rectangle(0, SIDE_M, apart_m)
    found, distance_m = figures(mesh, truth.vertices_m, truth)  # points 10 mm apart, whose spacing must not count
    assert set(found) == {"points_to_mesh", "mesh_to_points", "mesh_to_truth", "truth_to_mesh"}
    for name, values in found.items():
        assert values == pytest.approx({"rms_mm": 0.3, "p95_mm": 0.3, "max_mm": 0.3}, abs=2e-4), name
    assert distance_m == pytest.approx(np.full(121, 3e-4), abs=1e-7)


def test_without_a_truth_there_are_no_figures_of_it():
    mesh = rectangle(0, SIDE_M)
    assert set(figures(mesh, mesh.vertices_m, None)[0]) == {"points_to_mesh", "mesh_to_points"}


def test_a_square_that_leans_by_a_millimetre_is_at_all_distances_up_to_it_alike():
    flat, leaning = rectangle(0, SIDE_M), rectangle(0, SIDE_M)
    leaning.vertices_m[:, 2] = 1e-3 * leaning.vertices_m[:, 0] / SIDE_M
    found, _ = figures(leaning, rectangle(0, SIDE_M, squares=10).vertices_m, flat)
    even = {"rms_mm": 1 / np.sqrt(3), "p95_mm": 0.95, "max_mm": 1.0}
    for name in ("mesh_to_points", "mesh_to_truth", "truth_to_mesh"):
        assert found[name] == pytest.approx(even, rel=0.01), name


def test_what_the_mesh_lacks_is_seen_from_the_truth_alone_and_by_area_not_by_triangles():
    """The mesh ends half-way: half of the truth, in a hundredth of its triangles, lies at all distances up to 0.1 m from it."""
    mesh = rectangle(0, SIDE_M)
    truth = both(rectangle(0, SIDE_M, squares=10), rectangle(SIDE_M, 2 * SIDE_M))
    found, _ = figures(mesh, mesh.vertices_m, truth)
    assert found["mesh_to_truth"]["max_mm"] == pytest.approx(0.0, abs=1e-4)
    assert found["truth_to_mesh"] == pytest.approx(
        {"rms_mm": 100 / np.sqrt(6), "p95_mm": 90.0, "max_mm": 100.0}, rel=0.02
    )


def test_a_tenth_of_the_points_a_millimetre_off_makes_the_figures_of_the_points_and_no_others():
    mesh = rectangle(0, SIDE_M)
    points = rectangle(0, SIDE_M, squares=9).vertices_m
    points[::10, 2] = -1e-3
    found, distance_m = figures(mesh, points, mesh)
    assert found["points_to_mesh"] == pytest.approx({"rms_mm": np.sqrt(0.1), "p95_mm": 1.0, "max_mm": 1.0}, abs=1e-4)
    assert distance_m == pytest.approx(-points[:, 2], abs=1e-7)
    assert found["mesh_to_truth"]["max_mm"] == found["truth_to_mesh"]["max_mm"] == pytest.approx(0.0, abs=1e-4)


def test_samples_lie_evenly_within_their_triangle():
    corners = np.array([[0.0, 0, 0], [1.0, 0, 0], [0, 1.0, 0]])
    points = samples_on(Shape(vertices_m=corners, faces=np.array([[0, 1, 2]])), 20_000, np.random.default_rng(0))
    assert points.min() >= 0.0
    assert points[:, :2].sum(axis=1).max() <= 1.0 + 1e-12
    assert points[:, :2].mean(axis=0) == pytest.approx([1 / 3, 1 / 3], rel=0.02)
    assert (points[:, :2] ** 2).mean(axis=0) == pytest.approx([1 / 6, 1 / 6], rel=0.03)  # of an even triangle
