"""Vertices that answer to each other, and where their groups find them."""

from itertools import pairwise

import numpy as np
import pytest

from sim1.cloth.precise.mesh import refined, square_sheet
from sim1.cloth.precise.pairs import pairs_of


@pytest.fixture
def sheet():
    return refined(square_sheet(5, 0.3))[0]


def test_every_pair_is_there_once_and_in_the_order_of_a_band(sheet):
    pair, _ = pairs_of(sheet)
    assert (pair[:, 0] >= pair[:, 1]).all()
    assert len(np.unique(pair, axis=0)) == len(pair)
    assert (np.diff(pair[:, 1] * len(sheet.material_m) + pair[:, 0]) > 0).all()


def test_rings_and_stencils_find_their_pairs_row_by_row(sheet):
    pair, (of_rings, of_stencils, _) = pairs_of(sheet)
    stencils, stars = sheet.stencils, sheet.stars
    for places, first, node in ((of_rings, stars[3], stars[4]), (of_stencils, stencils.first, stencils.node)):
        number = 0
        for begin, end in pairwise(first):
            for a in range(begin, end):
                for b in range(begin, a + 1):
                    assert tuple(pair[places[number]]) == (node[a], node[b])
                    number += 1
        assert number == len(places)


def test_corners_of_a_face_find_their_pair_whichever_comes_first(sheet):
    pair, (_, _, of_faces) = pairs_of(sheet)
    for face, places in zip(sheet.faces, of_faces, strict=True):
        for a, i in enumerate(face):
            for b, j in enumerate(face):
                assert tuple(pair[places[a, b]]) == (max(i, j), min(i, j))
