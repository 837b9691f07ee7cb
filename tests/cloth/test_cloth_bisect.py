"""What plays reality is simulated on a finer mesh of the same garment, whose first vertices are the garment's own."""

import numpy as np
import pytest

from sim1.cloth.bisect import bisected
from sim1.cloth.garment import GarmentMesh, checked_mesh, face_areas, grid_towel, unique_edges


def uneven() -> GarmentMesh:
    """A sheet of irregular triangles."""
    towel = grid_towel(0.3, 0.2, 0.04)
    inner = np.abs(towel.rest_m[:, 0]) < 0.14
    moved = towel.rest_m + 0.008 * inner[:, None] * np.random.default_rng(0).uniform(-1, 1, towel.rest_m.shape) * [
        1,
        0,
        0,
    ]
    return checked_mesh(moved, towel.faces, moved)


@pytest.fixture(params=[lambda: grid_towel(0.3, 0.2, 0.04), uneven], ids=["even", "uneven"])
def garment(request):
    return request.param()


def test_the_garment_s_own_vertices_come_first_and_the_others_in_the_middle_of_edges(garment):
    finer = bisected(garment)
    count = len(garment.rest_m)
    np.testing.assert_array_equal(finer.mesh.rest_m[:count], garment.rest_m)
    np.testing.assert_array_equal(finer.refined(garment.vertices_m), finer.mesh.vertices_m)
    known = {tuple(edge) for edge in unique_edges(garment.faces)}
    assert {tuple(sorted(edge)) for edge in finer.parents.tolist()} <= known


def test_area_and_orientation_are_kept_and_no_vertex_lies_on_an_edge(garment):
    finer = bisected(garment).mesh
    assert face_areas(finer.rest_m, finer.faces).sum() == pytest.approx(face_areas(garment.rest_m, garment.faces).sum())
    corners = finer.rest_m[finer.faces]
    up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert (up > 0.0).all()

    def rim(mesh: GarmentMesh) -> float:
        """Length of edges with one face; a vertex on an edge would add edges inside."""
        pairs = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        edges, counts = np.unique(pairs, axis=0, return_counts=True)
        assert counts.max() == 2
        one = edges[counts == 1]
        return float(np.linalg.norm(mesh.rest_m[one[:, 0]] - mesh.rest_m[one[:, 1]], axis=1).sum())

    assert rim(finer) == pytest.approx(rim(garment))


def test_every_triangle_is_cut_and_none_becomes_a_sliver(garment):
    finer = bisected(garment).mesh
    assert 2 * len(garment.faces) <= len(finer.faces) <= 4 * len(garment.faces)

    def least_angle(mesh: GarmentMesh) -> float:
        corners = mesh.rest_m[mesh.faces]
        sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        a, b, c = np.sort(sides, axis=1).T
        return float(np.arccos((b**2 + c**2 - a**2) / (2 * b * c)).min())

    assert least_angle(finer) >= 0.5 * least_angle(garment) - 1e-9  # Rosenberg and Stenger (1975)


def test_a_motion_that_the_coarse_mesh_can_make_is_the_same_on_the_finer_one(garment):
    finer = bisected(garment)
    turn = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    moved = garment.rest_m @ turn.T + [0.1, 0.2, 0.3]
    np.testing.assert_allclose(finer.refined(moved), finer.mesh.rest_m @ turn.T + [0.1, 0.2, 0.3], atol=1e-12)
