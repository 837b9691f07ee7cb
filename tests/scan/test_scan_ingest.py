"""The scan stage against good files, damaged files and wrong units."""

import numpy as np
import pytest

from sim1.scan.cloud import read_scan
from sim1.scan.ply import read_ply, write_ply
from sim1.scan.stage import check_scan
from sim1.stage import BadInput

ARRAYS = ("points.npz", "views.npz", "garment.json", "scan.png")


def folder_with(tmp_path, sheet, name="scan.ply", **write):
    folder = tmp_path / f"scans_{len(list(tmp_path.glob('scans_*')))}"
    folder.mkdir()
    write_ply(folder / name, sheet, **write)
    return folder


def ascii_ply(sheet, extra=""):
    kinds = {"f": "float", "u": "uchar"}
    head = ["ply", "format ascii 1.0", *([extra] if extra else []), f"element vertex {len(sheet['x'])}"]
    head += [f"property {kinds[column.dtype.kind]} {name}" for name, column in sheet.items()]
    rows = [" ".join(str(value) for value in row) for row in zip(*sheet.values(), strict=True)]
    return "\n".join([*head, "end_header", *rows]) + "\n"


def same_bytes(first, second):
    return all((first / name).read_bytes() == (second / name).read_bytes() for name in ARRAYS)


def test_ascii_and_binary_ply_give_the_same_artifact(tmp_path, sheet, ingest_plain):
    binary = ingest_plain(folder_with(tmp_path, sheet))
    text = folder_with(tmp_path, sheet)
    (text / "scan.ply").write_text(ascii_ply(sheet))
    assert same_bytes(binary, ingest_plain(text))


def test_a_comment_in_the_scan_or_the_garment_file_changes_no_byte(tmp_path, sheet, ingest_plain, garment_file):
    before = ingest_plain(folder_with(tmp_path, sheet))
    garment_file.write_text("# a remark\n" + garment_file.read_text())
    assert same_bytes(before, ingest_plain(folder_with(tmp_path, sheet, comments=("scanned on a Monday",))))


def test_moving_one_point_changes_the_artifact(tmp_path, sheet, ingest_plain):
    before = ingest_plain(folder_with(tmp_path, sheet))
    sheet["z"] = sheet["z"].copy()
    sheet["z"][700] += 1e-4
    after = ingest_plain(folder_with(tmp_path, sheet))
    assert (before / "points.npz").read_bytes() != (after / "points.npz").read_bytes()


def test_obj_point_cloud_equals_the_ply(tmp_path, sheet, ingest_plain):
    folder = tmp_path / "obj"
    folder.mkdir()
    rows = zip(*(sheet[name].tolist() for name in ("x", "y", "z", "red", "green", "blue")), strict=True)
    (folder / "shirt.obj").write_text("# mine\n" + "\n".join("v " + " ".join(map(repr, row)) for row in rows))
    ours, ply = (read_scan(ingest_plain(f)).cloud for f in (folder, folder_with(tmp_path, sheet)))
    np.testing.assert_allclose(ours.points_m, ply.points_m, atol=1e-7)
    np.testing.assert_array_equal(ours.colors, ply.colors)


def test_a_mesh_is_sampled_densely_with_its_normals(tmp_path, ingest_plain):
    folder = tmp_path / "mesh"
    folder.mkdir()
    (folder / "m.obj").write_text("v 0 0 0\nv 0.4 0 0\nv 0.4 0.3 0\nv 0 0.3 0\nf 1 2 3 4\n")
    cloud = read_scan(ingest_plain(folder)).cloud
    assert len(cloud) == pytest.approx(0.12 / 0.003**2, rel=0.01)
    np.testing.assert_allclose(cloud.normals, np.broadcast_to([0.0, 0.0, 1.0], cloud.normals.shape), atol=1e-6)


@pytest.mark.parametrize(("scale", "units"), [(1000.0, "mm"), (100.0, "cm")])
def test_wrong_units_are_named(tmp_path, sheet, ingest_plain, scale, units):
    scaled = {name: column * np.float32(scale) if name in "xyz" else column for name, column in sheet.items()}
    with pytest.raises(BadInput, match=rf"scan\.ply.*look like.*\b{units}\b.*set units"):
        ingest_plain(folder_with(tmp_path, scaled))


def test_inches_are_recognised(tmp_path, sheet, ingest_plain):
    scaled = {name: column / np.float32(0.0254) if name in "xyz" else column for name, column in sheet.items()}
    with pytest.raises(BadInput, match=r"15\.7.* m long.*\bin\b"):
        ingest_plain(folder_with(tmp_path, scaled))


def test_metres_read_as_millimetres_are_named(tmp_path, sheet, ingest_plain, garment_file):
    garment_file.write_text(
        garment_file.read_text().replace("units: m ", "units: mm ").replace("units: m\n", "units: mm\n")
    )
    with pytest.raises(BadInput, match=r"0\.0004 m long.*look like m\b"):
        ingest_plain(folder_with(tmp_path, sheet))


def test_declared_millimetres_give_the_same_metres(tmp_path, sheet, ingest_plain, garment_file):
    metres = read_scan(ingest_plain(folder_with(tmp_path, sheet))).cloud.points_m
    garment_file.write_text(garment_file.read_text().replace("units: m\n", "units: mm\n"))
    scaled = {name: column * np.float32(1000) if name in "xyz" else column for name, column in sheet.items()}
    np.testing.assert_allclose(read_scan(ingest_plain(folder_with(tmp_path, scaled))).cloud.points_m, metres, atol=1e-7)


def test_frame_turns_y_up_files_upright(tmp_path, sheet, ingest_plain, garment_file):
    garment_file.write_text(garment_file.read_text() + "frame: {up: y, front: z}\n")
    points = read_scan(ingest_plain(folder_with(tmp_path, sheet))).cloud.points_m
    np.testing.assert_allclose(points, np.stack([sheet["z"], sheet["x"], sheet["y"]], axis=1), atol=1e-7)


def test_nan_point_is_named(tmp_path, sheet, ingest_plain):
    sheet["y"] = sheet["y"].copy()
    sheet["y"][41] = np.nan
    with pytest.raises(BadInput, match=r"scan\.ply: 1 of 1900 points are not finite, the first is point 41"):
        ingest_plain(folder_with(tmp_path, sheet))


def test_empty_cloud_few_points_and_no_file_are_refused(tmp_path, sheet, ingest_plain):
    with pytest.raises(BadInput, match="empty"):
        ingest_plain(folder_with(tmp_path, {name: column[:0] for name, column in sheet.items()}))
    with pytest.raises(BadInput, match="50 points; a garment needs at least 1000"):
        ingest_plain(folder_with(tmp_path, {name: column[::38] for name, column in sheet.items()}))
    (tmp_path / "nothing").mkdir()
    with pytest.raises(BadInput, match=r"no scan \(\*\.ply or \*\.obj\)"):
        ingest_plain(tmp_path / "nothing")


@pytest.mark.parametrize("keep", [0, 2, 60, 5000, -1])
def test_truncated_binary_ply_is_refused(tmp_path, sheet, ingest_plain, keep):
    folder = folder_with(tmp_path, sheet)
    path = folder / "scan.ply"
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(BadInput, match=r"scan\.ply.*(truncated|empty|not a PLY)"):
        ingest_plain(folder)


def test_truncated_ascii_ply_is_refused(tmp_path, sheet, ingest_plain):
    folder = folder_with(tmp_path, sheet)
    (folder / "scan.ply").write_text(ascii_ply(sheet)[:-200])
    with pytest.raises(BadInput, match="truncated"):
        ingest_plain(folder)


def test_unknown_and_missing_keys_of_the_garment_file_are_named(tmp_path, sheet, ingest_plain, garment_file):
    folder, text = folder_with(tmp_path, sheet), garment_file.read_text()
    garment_file.write_text(text + "colour: red\n")
    with pytest.raises(BadInput, match=r"garment\.yaml: unknown key 'colour'"):
        ingest_plain(folder)
    garment_file.write_text(text.replace("openings: 1", "openings: 0"))
    with pytest.raises(BadInput, match=r"openings is 0"):
        ingest_plain(folder)
    garment_file.write_text(text.replace("units: m\n", ""))
    with pytest.raises(BadInput, match=r"key 'units' is missing"):
        ingest_plain(folder)


def test_damaged_poses_and_masks_are_refused(tmp_path, sheet, ingest_plain):
    folder = folder_with(tmp_path, sheet)
    (folder / "views.json").write_text('{"views": [{"scanner_to_world": [[1, 0], [0, 1]]}]}')
    with pytest.raises(BadInput, match=r"views\.json: poses have shape"):
        ingest_plain(folder)
    (folder / "views.json").unlink()
    np.savez(folder / "mask.npz", garment=np.ones(7, bool))
    with pytest.raises(BadInput, match=r"mask\.npz.*1900"):
        ingest_plain(folder)


def test_a_plain_file_is_not_taken_for_a_virtual_scan(tmp_path, sheet, ingest_plain, garment_file):
    garment_file.write_text(garment_file.read_text().replace("virtual: false", "virtual: true"))
    with pytest.raises(BadInput, match=r"virtual is True, but truth\.npz is missing"):
        ingest_plain(folder_with(tmp_path, sheet))


def test_check_finds_strays(tmp_path, sheet, ingest_plain):
    findings = {f.name: f for f in check_scan(ingest_plain(folder_with(tmp_path, sheet)))}
    assert [name for name, f in findings.items() if not f.passed] == ["support_known"]  # nothing tells it from a table
    rng = np.random.default_rng(1)
    for name in "xyz":
        sheet[name] = np.concatenate([sheet[name], rng.uniform(-1, 1, 60)]).astype(np.float32)
    for name in ("red", "green", "blue"):
        sheet[name] = np.concatenate([sheet[name], np.zeros(60, np.uint8)])
    findings = {f.name: f for f in check_scan(ingest_plain(folder_with(tmp_path, sheet)))}
    assert not findings["few_strays"].passed


def test_a_scan_without_support_and_mask_is_warned_of_and_a_mask_is_an_answer(tmp_path, sheet, ingest_plain):
    folder = folder_with(tmp_path, sheet)
    finding = {f.name: f for f in check_scan(ingest_plain(folder))}["support_known"]
    assert not finding.passed
    assert not finding.blocking
    assert "becomes part of the garment; cut it away or give it as support.ply" in finding.detail
    np.savez(folder / "mask.npz", garment=np.ones(len(sheet["x"]), bool))
    assert {f.name: f for f in check_scan(ingest_plain(folder))}["support_known"].passed


def test_ply_reader_takes_big_endian_and_polygons(tmp_path):
    head = b"ply\nformat binary_big_endian 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
    head += b"element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    corners = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], ">f8")
    (tmp_path / "q.ply").write_bytes(head + corners.tobytes() + b"\x04" + np.arange(4, dtype=">i4").tobytes())
    vertex, faces = read_ply(tmp_path / "q.ply")
    assert vertex["y"].tolist() == [0, 0, 1, 1]
    assert faces.tolist() == [[0, 1, 2], [0, 2, 3]]
