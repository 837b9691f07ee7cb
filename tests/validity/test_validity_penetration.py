"""Edges that pass through faces."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim1.cloth.garment import unique_edges
from sim1.validity.penetration import crossings

FLAT = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])


def two(other: np.ndarray) -> np.ndarray:
    """Pairs of a fixed triangle in the plane z = 0 and another one."""
    return crossings(np.concatenate([FLAT, other]), np.array([[0, 1, 2], [3, 4, 5]]))


@pytest.mark.parametrize(
    ("tip", "count"),
    [((0.2, 0.2, -0.1), 2), ((0.2, 0.2, 0.1), 0), ((0.9, 0.9, -0.1), 0)],
)
def test_a_corner_pushed_through_a_face_is_two_crossing_edges(tip, count):
    assert len(two(np.array([[0.1, 0.2, 0.5], [0.2, 0.1, 0.5], tip]))) == count


def test_edge_and_face_are_named():
    found = two(np.array([[0.1, 0.2, 0.5], [0.2, 0.1, 0.5], [0.2, 0.2, -0.1]]))
    edges = unique_edges(np.array([[0, 1, 2], [3, 4, 5]]))
    assert {tuple(edges[edge]) for edge, _ in found} == {(3, 5), (4, 5)}
    assert set(found[:, 1]) == {0}


def test_faces_that_share_a_vertex_or_lie_in_one_plane_do_not_pass_through_each_other():
    fan = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0.0]])
    assert len(crossings(fan, np.array([[0, 1, 2], [0, 2, 3]]))) == 0
    assert len(two(FLAT + np.array([0.1, 0.1, 0]))) == 0


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, 3), st.floats(0.01, 50), st.integers(0, 999))
def test_moving_turning_and_scaling_change_nothing(x, y, z, scale, seed):
    rng = np.random.default_rng(seed)
    other = rng.uniform(-1, 1, (3, 3))
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    points = np.concatenate([FLAT, other])
    faces = np.array([[0, 1, 2], [3, 4, 5]])
    moved = scale * (points @ turn.T) + [x, y, z]
    assert len(crossings(points, faces)) == len(crossings(moved, faces))
