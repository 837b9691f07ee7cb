"""Scan files as other programs write them, and what is said of those that cannot be used."""

import numpy as np
import pytest

from sim1.scan.cloud import Shape, read_scan
from sim1.scan.garment_file import read_garment_file
from sim1.scan.obj import read_obj
from sim1.scan.ply import write_ply
from sim1.scan.poisson import cut_open
from sim1.scan.stage import GarmentMeshConfig, garment_mesh
from sim1.stage import BadInput


@pytest.fixture
def folder(tmp_path, sheet):
    """Scans of one garment: the coloured sheet."""
    made = tmp_path / "scans"
    made.mkdir()
    write_ply(made / "scan.ply", sheet)
    return made


@pytest.mark.parametrize("name", ["support.PLY", "Support.ply", "SUPPORT.PLY"])
def test_a_support_is_no_view_of_the_garment_however_its_name_is_written(folder, sheet, ingest_plain, name):
    corners = np.array([[-0.3, -0.3, -0.1], [0.3, -0.3, -0.1], [0.3, 0.3, -0.1]], np.float32)
    write_ply(folder / name, dict(zip("xyz", corners.T, strict=True)), np.array([[0, 1, 2]], np.int32))
    scan = read_scan(ingest_plain(folder))
    assert len(scan.cloud) == len(sheet["x"])
    assert scan.support.faces.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize("top", [1.0, 255.0])
def test_colours_that_are_fractions_or_floats_up_to_255_are_told_apart(folder, sheet, ingest_plain, top):
    floats = {name: (sheet[name] * (top / 255.0)).astype(np.float32) for name in ("red", "green", "blue")}
    floats["red"][0] = top  # somewhere it is bright
    write_ply(folder / "scan.ply", sheet | floats)
    colors = read_scan(ingest_plain(folder)).cloud.colors
    assert colors[0, 0] == 255
    np.testing.assert_array_equal(colors[1:, 0], sheet["red"][1:])
    np.testing.assert_array_equal(colors[:, 1], sheet["green"])


@pytest.mark.parametrize("index", [-5, 0])
def test_a_face_that_names_a_vertex_before_the_first_is_refused_with_its_line(tmp_path, index):
    path = tmp_path / "m.obj"
    path.write_text(f"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 {index}\n")
    with pytest.raises(
        BadInput, match=rf"m\.obj: line 5, .*: not valid OBJ \(vertex index {index}, with 4 vertices so far"
    ):
        read_obj(path)
    path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 -4\n")  # the first, counted from the last
    assert read_obj(path)[1].tolist() == [[0, 1, 0]]


def test_a_key_that_stands_twice_in_a_garment_file_is_refused(garment_file):
    garment_file.write_text(garment_file.read_text() + "units: mm\n")
    with pytest.raises(BadInput, match=r"garment\.yaml: not readable as YAML \(the key 'units' occurs twice"):
        read_garment_file(garment_file)


def test_a_garment_file_that_cannot_be_read_is_named_with_where_to_find_one(tmp_path):
    (tmp_path / "folder.yaml").mkdir()
    for name, reason in (("missing.yaml", "No such file"), ("folder.yaml", "Is a directory")):
        with pytest.raises(BadInput, match=rf"{name}: cannot be read \({reason}.*scan-format\.md"):
            read_garment_file(tmp_path / name)


def test_a_scan_of_which_no_mesh_can_be_made_is_named_with_the_files_it_came_from(
    folder, sheet, ingest_plain, tmp_path
):
    mask = np.zeros(len(sheet["x"]), bool)
    mask[:50] = True
    np.savez(folder / "mask.npz", garment=mask)
    artifact = ingest_plain(folder)
    where = rf"^{artifact} \(data/scans/mine, data/garments/mine\.yaml\): only 50 of 1900 points"
    with pytest.raises(BadInput, match=where):
        garment_mesh({"scan": {"mine": artifact}}, tmp_path, GarmentMeshConfig())


def plane_with_gaps(spacing_m: float = 0.005) -> tuple[Shape, np.ndarray]:
    """A plane, and points on it that leave a square of 140 mm free, and one of 120 mm but for an island in it."""
    x, y = (axis.ravel() for axis in np.meshgrid(*(spacing_m * np.arange(count) for count in (81, 41)), indexing="ij"))
    vertices = np.stack([x, y, 0 * x], axis=1)
    corner = np.arange(81 * 41).reshape(81, 41)
    a, b, c, d = (part.ravel() for part in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])

    def inside(x_m: float, half_m: float) -> np.ndarray:
        return (np.abs(x - x_m) < half_m) & (np.abs(y - 0.1) < half_m)

    free = inside(0.3, 0.07) | (inside(0.1, 0.06) & ~inside(0.1, 0.03))
    return Shape(vertices_m=vertices, faces=faces.astype(np.int32)), vertices[~free]


def test_the_opening_is_the_gap_with_the_longest_rim_and_not_that_with_the_most_rims():
    surface, points = plane_with_gaps()
    opened, gaps_m = cut_open(surface, points, openings=1, reach_m=0.004, edge_m=0.004)
    assert gaps_m == pytest.approx([4 * 0.14, 4 * 0.12], rel=0.05)
    in_square, in_ring = (np.abs(opened.vertices_m - [x, 0.1, 0]).max(axis=1) < 0.05 for x in (0.3, 0.1))
    assert not in_square.any()
    assert in_ring.any()
