"""The stage garment_mesh, end to end on a small virtual scan, and its check against damaged meshes."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from sim1.scan.remesh import area_m2
from sim1.scan.rims import rim_lengths_m
from sim1.scan.stage import GarmentMeshConfig, ScanConfig, check_garment_mesh, check_scan, garment_mesh, scan
from sim1.stage import BadInput

DATA = Path(__file__).parents[2] / "data"
CONFIG = GarmentMeshConfig(cell_m=0.005, edge_m=0.034, vertex_count=300, texture_pixels=128)


@pytest.fixture(scope="module")
def scanned(small_scan, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("scan")
    scan({"garment": {"towel": DATA / "garments/towel.yaml"}, "scans": {"towel": small_scan}}, out, ScanConfig())
    assert all(finding.passed for finding in check_scan(out))
    return out


@pytest.fixture(scope="module")
def meshed(scanned, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("mesh")
    facts = garment_mesh({"scan": {"towel": scanned}}, out, CONFIG)
    assert facts["origin"] == "virtual scan"
    assert facts["separation"] == "registered support"
    assert facts["points_left_out"] > 100
    return out


@pytest.fixture
def damaged(meshed, tmp_path):
    """Function that rewrites the mesh with other arrays and returns the names of the checks that fail."""

    def check(**changes) -> set[str]:
        folder = tmp_path / "damaged"
        shutil.copytree(meshed, folder, dirs_exist_ok=True)
        with np.load(meshed / "mesh.npz") as data:
            arrays = {name: data[name] for name in data.files}
        np.savez(folder / "mesh.npz", **arrays | changes)
        return {finding.name for finding in check_garment_mesh(folder) if finding.blocking and not finding.passed}

    return check


def arrays_of(folder: Path) -> dict[str, np.ndarray]:
    with np.load(folder / "mesh.npz") as data:
        return {name: data[name] for name in data.files}


def test_the_mesh_of_a_virtual_scan_passes_every_check(meshed):
    assert [finding for finding in check_garment_mesh(meshed) if not finding.passed] == []


def test_the_mesh_is_within_half_a_millimetre_of_points_and_truth(meshed):
    before = json.loads((meshed / "accuracy.json").read_text())["before_remeshing"]
    assert before["points_to_mesh"]["rms_mm"] < 0.5
    assert before["mesh_to_truth"]["rms_mm"] < 0.5
    assert before["truth_to_mesh"]["rms_mm"] < 0.5


def test_the_mesh_has_the_size_of_the_towel(meshed):
    arrays = arrays_of(meshed)
    assert 80 < len(arrays["vertices_m"]) < 200
    rest = arrays["rest_m"].astype(float)
    assert np.linalg.svd(rest - rest.mean(axis=0), compute_uv=False)[2] < 1e-6  # flat
    assert area_m2(rest, arrays["faces"]) == pytest.approx(0.4 * 0.3, rel=0.015)
    assert rim_lengths_m(rest, arrays["faces"]) == pytest.approx([1.4], rel=0.02)
    np.testing.assert_allclose(np.ptp(arrays["vertices_m"], axis=0)[:2], [0.4, 0.3], atol=0.004)
    assert arrays["uv"].shape == (len(arrays["faces"]), 3, 2)
    assert {name: array.dtype.str for name, array in arrays.items()} == {
        "vertices_m": "<f4",
        "faces": "<i4",
        "uv": "<f4",
        "rest_m": "<f4",
    }


def test_the_texture_shows_the_scanned_colours(meshed):
    """The colour of each face's middle in the texture is that of the towel there."""
    from PIL import Image

    from sim1.scan.virtual.garments import towel

    arrays = arrays_of(meshed)
    image = np.asarray(Image.open(meshed / "texture.png"), float)
    middle = arrays["uv"].mean(axis=1)
    pixel = image[((1 - middle[:, 1]) * 128).astype(int).clip(0, 127), (middle[:, 0] * 128).astype(int).clip(0, 127)]
    truth = towel().color(arrays["vertices_m"][arrays["faces"]].mean(axis=1).astype(float))
    assert np.median(np.abs(pixel - truth)) < 8
    assert (np.abs(pixel - truth).max(axis=1) < 60).mean() > 0.9


def test_the_obj_file_holds_the_same_mesh(meshed):
    from sim1.scan.obj import read_obj

    vertex, faces = read_obj(meshed / "garment.obj")
    arrays = arrays_of(meshed)
    np.testing.assert_array_equal(faces, arrays["faces"])
    np.testing.assert_allclose(np.stack([vertex[name] for name in "xyz"], axis=1), arrays["vertices_m"], atol=1e-6)


def test_the_artifact_has_the_same_bytes_every_time(meshed, scanned, tmp_path):
    again = tmp_path / "again"
    again.mkdir()
    garment_mesh({"scan": {"towel": scanned}}, again, CONFIG)
    names = sorted(path.name for path in meshed.iterdir())
    assert names == sorted(path.name for path in again.iterdir())
    assert [name for name in names if (meshed / name).read_bytes() != (again / name).read_bytes()] == []


def test_checks_find_a_sliver(meshed, damaged):
    arrays = arrays_of(meshed)
    vertices, face = arrays["vertices_m"].copy(), arrays["faces"][0]
    vertices[face[0]] = vertices[face[1]] + 0.01 * (vertices[face[2]] - vertices[face[1]])
    assert "minimum_angle" in damaged(vertices_m=vertices)


def test_checks_find_a_hole_a_flipped_face_and_a_loose_vertex(meshed, damaged):
    arrays = arrays_of(meshed)
    inner = len(arrays["faces"]) // 2
    faces = arrays["faces"].copy()
    faces[inner] = faces[inner][::-1]
    assert "orientation_consistent" in damaged(faces=faces)
    assert "vertices_used" in damaged(vertices_m=np.concatenate([arrays["vertices_m"], [[0, 0, 0]]]))
    border = arrays["vertices_m"][:, :2].min()
    middle = int(np.linalg.norm(arrays["vertices_m"][:, :2], axis=1).argmin())
    kept = ~(arrays["faces"] == middle).any(axis=1)
    assert border < 0
    assert "openings" in damaged(faces=arrays["faces"][kept], uv=arrays["uv"][kept])


def test_checks_find_a_value_that_is_not_finite_and_two_pieces(meshed, damaged):
    arrays = arrays_of(meshed)
    rest = arrays["rest_m"].copy()
    rest[3, 1] = np.nan
    assert "finite" in damaged(rest_m=rest)
    twice = {name: np.concatenate([arrays[name], arrays[name]]) for name in ("vertices_m", "uv", "rest_m")}
    count = len(arrays["vertices_m"])
    assert {"one_piece", "openings"} <= damaged(
        **twice, faces=np.concatenate([arrays["faces"], arrays["faces"] + count])
    )


def test_checks_find_an_inaccurate_mesh(meshed, tmp_path):
    folder = tmp_path / "inaccurate"
    shutil.copytree(meshed, folder)
    figures = json.loads((folder / "accuracy.json").read_text())
    figures["before_remeshing"]["mesh_to_truth"]["rms_mm"] = 0.51
    (folder / "accuracy.json").write_text(json.dumps(figures))
    assert [f.name for f in check_garment_mesh(folder) if not f.passed] == ["mesh_to_truth_rms"]


def test_a_plain_cloud_without_poses_or_support_becomes_a_mesh(tmp_path):
    """What a user brings: one OBJ of points, no colours, no normals, in centimetres, y up."""
    rng = np.random.default_rng(4)
    angle, height = rng.uniform(0, 2 * np.pi, 9000), rng.uniform(0, 30, 9000)
    points = np.stack([8 * np.sin(angle), height, 8 * np.cos(angle)], axis=1)
    folder = tmp_path / "scans"
    folder.mkdir()
    (folder / "skirt.obj").write_text("\n".join("v {:.5f} {:.5f} {:.5f}".format(*point) for point in points))
    text = (DATA / "garments/towel.yaml").read_text().replace("virtual: true", "virtual: false")
    text = (
        text.replace("openings: 1", "openings: 2").replace("units: m\n", "units: cm\n") + "frame: {up: y, front: z}\n"
    )
    (tmp_path / "skirt.yaml").write_text(text)
    scanned, meshed = tmp_path / "scan", tmp_path / "mesh"
    scanned.mkdir()
    meshed.mkdir()
    scan({"garment": {"skirt": tmp_path / "skirt.yaml"}, "scans": {"skirt": folder}}, scanned, ScanConfig())
    facts = garment_mesh({"scan": {"skirt": scanned}}, meshed, CONFIG)
    assert (facts["separation"], facts["points_left_out"]) == ("no support given", 0)
    (warned,) = [finding for finding in check_garment_mesh(meshed) if not finding.passed]
    assert (warned.name, warned.blocking) == ("support_removed", False)
    assert "0 of 9000 points left out" in warned.detail
    assert "support.ply" in warned.detail
    figures = json.loads((meshed / "accuracy.json").read_text())
    assert not figures["virtual"]
    assert figures["openings_m"] == pytest.approx([2 * np.pi * 0.08] * 2, rel=0.05)
    assert "mesh_to_truth" not in figures["before_remeshing"]


def test_a_scan_that_shows_nothing_but_the_support_is_refused(scanned, tmp_path):
    broken = tmp_path / "broken"
    shutil.copytree(scanned, broken)
    with np.load(broken / "points.npz") as data, np.load(broken / "truth.npz") as truth:
        points = {name: data[name][~truth["garment"]] for name in data.files}
    np.savez(broken / "points.npz", **points)
    (broken / "truth.npz").unlink()
    with pytest.raises(BadInput, match="not taken for the support"):
        garment_mesh({"scan": {"towel": broken}}, tmp_path, CONFIG)


def test_a_damaged_scan_artifact_is_named(scanned, tmp_path):
    broken = tmp_path / "broken"
    shutil.copytree(scanned, broken)
    (broken / "points.npz").write_bytes((broken / "points.npz").read_bytes()[:1000])
    with pytest.raises(BadInput, match=r"points\.npz: damaged"):
        garment_mesh({"scan": {"towel": broken}}, tmp_path, CONFIG)
