"""Meshes that cannot be laid flat are refused with face and file."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import SIDE_M, empty_bundle

from sim1.cloth.precise.material import marker_points, sheet_of
from sim1.cloth.precise.mesh import square_sheet
from sim1.cloth.precise.scene import prepare
from sim1.stage import BadInput


@pytest.fixture(scope="module")
def bundle():
    return empty_bundle(count=5, duration_s=1.2, motions=1)


def with_mesh(bundle, **parts):
    return replace(bundle, mesh=replace(bundle.mesh, **parts))


def test_a_flat_mesh_without_material_coordinates_is_its_own_cloth(bundle):
    plain = with_mesh(bundle, material_m=None)
    lengths = [np.linalg.norm(np.diff(marker_points(one), axis=0), axis=1) for one in (plain, bundle)]
    np.testing.assert_allclose(*lengths, rtol=1e-12)
    assert sheet_of(plain).face_area_m2.sum() == pytest.approx(SIDE_M**2)


def test_a_mesh_that_is_not_flat_needs_material_coordinates(bundle):
    bowl = bundle.mesh.vertices_m.copy()
    bowl[:, 2] = 2.0 * ((bowl[:, :2] - SIDE_M / 2) ** 2).sum(1)
    with pytest.raises(
        BadInput, match=r"^garment\.obj: no material coordinates .* not flat, but 0\.\d+ times as thick"
    ):
        sheet_of(with_mesh(bundle, vertices_m=bowl, material_m=None))


@pytest.mark.parametrize("finer", [0, 1])
def test_a_face_without_area_is_named_as_the_file_counts_it(bundle, finer):
    material = bundle.mesh.material_m.copy()
    material[0] = material[1]
    with pytest.raises(BadInput, match=r"^garment\.obj: face 0 has no area in `vt` \(.* 1 such faces of 32\)"):
        prepare(with_mesh(bundle, material_m=material), bundle.recordings[0], 1 / 60, finer)


@pytest.mark.parametrize("finer", [0, 1])
def test_a_face_that_is_turned_over_is_named_as_the_file_counts_it(bundle, finer):
    faces = bundle.mesh.faces.copy()
    faces[[9, 20]] = faces[[9, 20]][:, ::-1]
    with pytest.raises(
        BadInput, match=r"^garment\.obj: face 9 lies the other way up in `vt` than most \(2 such faces of 32\)"
    ):
        prepare(with_mesh(bundle, faces=faces), bundle.recordings[0], 1 / 60, finer)


def test_a_square_sheet_counts_its_vertices_row_by_row():
    sheet = square_sheet(4, 0.3)
    np.testing.assert_allclose(sheet.material_m[2 * 4 + 1], [0.1, 0.2])
    assert sheet.face_area_m2.sum() == pytest.approx(0.09)
    assert len(sheet.faces) == 18


def test_without_material_coordinates_warp_and_weft_are_the_axes_of_the_mesh_itself(bundle):
    """Whatever is found at a place of the cloth, or along its threads, is told in a frame that its owner knows."""
    plain = with_mesh(bundle, material_m=None)
    np.testing.assert_allclose(sheet_of(plain).material_m, bundle.mesh.vertices_m[:, :2], atol=1e-12)
    hanging = bundle.mesh.vertices_m[:, [0, 2, 1]] * [1.0, 1.0, -1.0] + [0.1, 0.4, 0.0]  # in x and z, seen from behind
    material = sheet_of(with_mesh(bundle, material_m=None, vertices_m=hanging)).material_m
    np.testing.assert_allclose(material[:, 0], hanging[:, 0], atol=1e-12)
    np.testing.assert_allclose(np.abs(np.diff(material[:, 1])), np.abs(np.diff(hanging[:, 2])), atol=1e-12)
