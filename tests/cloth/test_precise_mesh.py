"""Stencils and order of a sheet's vertices: exact on uneven triangles, and no wider than on even ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim1.cloth.precise.mesh import Sheet, narrow, refined, reordered, square_sheet

SIDE_M = 0.3


def scattered(count, share, seed):
    """A square net whose inner vertices lie off their places by up to this share of the spacing."""
    sheet = square_sheet(count, SIDE_M)
    off = np.random.default_rng(seed).uniform(-share, share, sheet.material_m.shape) * SIDE_M / (count - 1)
    off[((sheet.material_m < 1e-9) | (sheet.material_m > SIDE_M - 1e-9)).any(1)] = 0.0
    return Sheet(material_m=sheet.material_m + off, faces=sheet.faces)


def reach(sheet):
    """How far apart in number two vertices lie that act on each other: by a stencil, or over two faces that touch."""
    most = max(np.ptp(nodes) for nodes in np.split(sheet.stencils.node, sheet.stencils.first[1:-1]))
    _, _, _, first, node = sheet.stars
    return max(most, *(np.ptp(nodes) for nodes in np.split(node, first[1:-1])))


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), share=st.floats(0.0, 0.2))
def test_stencils_of_uneven_triangles_take_derivatives_of_quadratics_exactly(seed, share):
    sheet = scattered(7, share, seed)
    u, v = sheet.material_m.T
    a, b, c, d, e = np.random.default_rng(seed).normal(size=5)
    height = a * u + b * v + c * u * u / 2 + d * v * v / 2 + e * u * v
    stencils = sheet.stencils
    second = np.add.reduceat(stencils.second * height[stencils.node, None], stencils.first[:-1])
    assert second == pytest.approx(np.tile([c, d, e], (len(second), 1)), abs=1e-9)
    slope = np.add.reduceat(stencils.slope * height[stencils.node, None], stencils.first[:-1])
    there = np.stack([a + c * u + e * v, b + d * v + e * u], axis=1)[stencils.centre]
    assert slope == pytest.approx(there, abs=1e-9)


@pytest.mark.parametrize("share", [0.0, 0.2])
def test_around_a_vertex_of_four_neighbours_a_stencil_takes_in_the_corners_of_its_block(share):
    count = 7
    sheet = scattered(count, share, seed=1)
    stencils = sheet.stencils
    crosses = 0
    for centre, nodes in zip(stencils.centre, np.split(stencils.node, stencils.first[1:-1]), strict=True):
        row, column = divmod(int(centre), count)
        if (row + column) % 2 == 1 and 0 < row < count - 1 and 0 < column < count - 1:
            crosses += 1
            block = [(row + i) * count + column + j for i in (-1, 0, 1) for j in (-1, 0, 1)]
            assert set(block) <= set(nodes.tolist())
            assert len(nodes) <= 10  # a corner of the sheet hangs on one of them
    assert crosses == 12


def test_where_the_faces_around_are_too_few_a_stencil_reaches_for_what_is_nearest():
    """Two squares that touch in a corner, each cut from its middle: five vertices around either, and nothing behind its edges."""
    low = np.array([(0, 0), (2, 0), (2, 2), (0, 2), (1, 1)])
    points = np.concatenate([low, [(4, 2), (4, 4), (2, 4), (3, 3)]]) * 0.05
    around = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (2, 5, 8), (5, 6, 8), (6, 7, 8), (7, 2, 8)]
    stencils = Sheet(material_m=points, faces=np.array(around)).stencils
    assert stencils.centre.tolist() == [4, 8]
    bent = np.add.reduceat(stencils.second * points.prod(1)[stencils.node, None], stencils.first[:-1])
    assert bent == pytest.approx(np.tile([0.0, 0.0, 1.0], (2, 1)), abs=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_an_uneven_net_in_any_order_is_put_in_one_as_narrow_as_an_even_net(seed):
    fine, _ = refined(scattered(8, 0.2, seed))
    mixed, _ = reordered(fine, np.random.default_rng(seed).permutation(len(fine.material_m)))
    ordered, _ = reordered(mixed, narrow(mixed))
    even = 2 * 15 + 2  # two rows of the refined net and two vertices more
    assert reach(ordered) <= even + 1 < reach(mixed)


def test_an_order_loses_no_vertex():
    sheet = scattered(6, 0.2, seed=3)
    assert np.sort(narrow(sheet)).tolist() == list(range(36))
