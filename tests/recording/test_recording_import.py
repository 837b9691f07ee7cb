"""A recording that went through the file of any system comes back as it was: units, axes, gaps, clocks, anchors."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from lab_files import (
    LABELS,
    WRITERS,
    change_import,
    gappy_swing,
    imported,
    lab_folder,
    write_c3d,
    write_long,
    write_motive,
    write_nexus,
    write_npz,
    y_up,
)
from scipy.spatial.transform import Rotation
from swinging import SIDE, board_bundle, board_markers, swing

from sim1.recording.examination import examine
from sim1.recording.importing.c3d_file import read_c3d
from sim1.recording.importing.write import import_bundle
from sim1.stage import BadInput

FLOAT32_M = 1e-7  # the bundle's own rounding


@pytest.fixture
def gappy():
    return gappy_swing()


def same(back, ours, tolerance_m):
    np.testing.assert_allclose(back.time_s, ours.time_s, atol=1e-6)
    np.testing.assert_array_equal(back.seen, ours.seen)
    np.testing.assert_allclose(back.markers_m, ours.markers_m, atol=tolerance_m + FLOAT32_M)
    one, other = back.drives["bar"], ours.drives["bar"]
    np.testing.assert_allclose(one.position_m, other.position_m, atol=1e-9)
    np.testing.assert_allclose(one.rotation_wxyz, other.rotation_wxyz, atol=1e-9)
    np.testing.assert_allclose(back.holds[0].places_m, ours.holds[0].places_m)


@pytest.mark.parametrize("kind", WRITERS)
def test_a_recording_comes_back_as_it_was(tmp_path, gappy, kind):
    write, ending, tolerance = WRITERS[kind]
    other = replace(swing("swing_b", peak_rad_s=1.0), name="swing_b")
    folder = lab_folder(tmp_path / "lab", gappy, other)
    for recording in (gappy, other):
        write(folder / f"{recording.name}.{ending}", recording)
    bundle = imported(folder, kind, "swing_a", "swing_b", units=None if kind != "csv" else "m")
    assert [recording.name for recording in bundle.recordings] == ["swing_a", "swing_b"]
    same(bundle.recordings[0], gappy, tolerance)
    same(bundle.recordings[1], other, tolerance)
    places = (bundle.mesh.vertices_m[bundle.mesh.faces[bundle.anchors.face]] * bundle.anchors.weight[..., None]).sum(1)
    np.testing.assert_allclose(places[:, :2], board_markers(), atol=1e-9)
    assert examine(folder / "bundle").usable


@pytest.mark.parametrize("unit", ["Meters", "Centimeters", "Millimeters"])
def test_motive_says_its_unit(tmp_path, gappy, unit):
    folder = lab_folder(tmp_path / "lab", gappy)
    write_motive(folder / "swing_a.csv", gappy, unit=unit)
    same(imported(folder, "motive", "swing_a").recordings[0], gappy, 1e-6)


def test_motive_measured_markers_are_taken_and_predicted_ones_are_not(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    write_motive(folder / "swing_a.csv", gappy)
    done = import_bundle("motive", [folder / "swing_a.csv"], folder / "bundle")
    assert done.left_out == ["Unlabeled 1189"]
    same(done.bundle.recordings[0], gappy, 2e-9)


def test_motive_without_names_of_its_header_rows_is_read_too(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    write_motive(folder / "swing_a.csv", gappy)
    text = (folder / "swing_a.csv").read_text()
    for word in ("Type", "Name", "ID"):
        text = text.replace(f"\n,{word},", "\n,,")
    (folder / "swing_a.csv").write_text(text)
    same(imported(folder, "motive", "swing_a").recordings[0], gappy, 2e-9)


def test_a_unit_in_the_column_names_is_obeyed(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    write_long(folder / "swing_a.csv", gappy, head="time_s,marker,x_mm,y_mm,z_mm", scale=1000.0)
    same(imported(folder, "csv", "swing_a").recordings[0], gappy, 2e-9)


def test_a_point_of_c3d_is_in_a_gap_by_its_residual_and_not_because_it_is_at_the_origin(tmp_path, gappy):
    at_origin = gappy.markers_m[0, 0].copy()
    gappy.markers_m[:] -= at_origin
    write_c3d(tmp_path / "swing_a.c3d", gappy)
    paths = read_c3d(tmp_path / "swing_a.c3d")
    np.testing.assert_array_equal(paths.positions_m[0, 0], [0.0, 0.0, 0.0])
    np.testing.assert_array_equal(np.isfinite(paths.positions_m[:, :16]).all(-1), gappy.seen)


def test_y_up_becomes_z_up_and_stays_right_handed(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    write_long(folder / "swing_a.csv", replace(gappy, markers_m=y_up(gappy.markers_m)))
    same(imported(folder, "csv", "swing_a", units="m", up="y").recordings[0], gappy, 2e-6)
    assert np.linalg.det(y_up(np.eye(3))) == pytest.approx(1)


def test_a_cloth_that_lies_on_its_side_because_of_its_axes_is_refused_where_a_table_shows_it(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    table = {"height_m": 0.4, "friction": {"value": 0.4}}
    change_import(folder, lambda c: c["environment"].update(table=table))
    write_long(folder / "swing_a.csv", replace(gappy, markers_m=y_up(gappy.markers_m)))
    with pytest.raises(BadInput, match="z up"):
        imported(folder, "csv", "swing_a", units="m")


def test_the_frame_of_the_cameras_is_laid_onto_that_of_the_robot(tmp_path, gappy):
    turn, shift = Rotation.from_euler("z", 0.7), np.array([0.5, -2.0, 0.1])
    seen_by_cameras = replace(
        gappy, markers_m=turn.inv().apply((gappy.markers_m - shift).reshape(-1, 3)).reshape(-1, 16, 3)
    )
    folder = lab_folder(tmp_path / "lab", gappy)
    frame = {"rotation_wxyz": turn.as_quat(scalar_first=True).tolist(), "shift_m": shift.tolist()}
    change_import(folder, lambda c: c["markers"].update(to_world=frame))
    write_npz(folder / "swing_a.npz", seen_by_cameras)
    same(imported(folder, "npz", "swing_a").recordings[0], gappy, 1e-9)


def test_a_late_clock_of_the_robot_is_shifted_and_the_recording_cut(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    drives = pd.read_csv(folder / "swing_a_drives.csv")
    drives.assign(time_s=drives["time_s"] + 1.7e9).to_csv(folder / "swing_a_drives.csv", index=False)

    def edit(content):
        content["recordings"]["swing_a"]["drives"]["shift_s"] = -1.7e9
        content["recordings"]["swing_a"]["cut_s"] = [0.5, 3.0]

    change_import(folder, edit)
    write_c3d(folder / "swing_a.c3d", gappy)
    [recording] = imported(folder, "c3d", "swing_a").recordings
    assert recording.time_s[0] == pytest.approx(0.5)
    assert recording.time_s[-1] == pytest.approx(3.0)
    assert recording.drives["bar"].time_s[[0, -1]] == pytest.approx([0.5, 3.0], abs=0.011)
    assert (recording.holds[0].from_s, recording.holds[0].to_s) == tuple(recording.drives["bar"].time_s[[0, -1]])


def test_drives_come_from_the_archive_of_the_markers(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    change_import(folder, lambda c: c["recordings"]["swing_a"].update(drives={"kind": "npz"}))
    write_npz(folder / "swing_a.npz", gappy)
    same(imported(folder, "npz", "swing_a").recordings[0], gappy, 1e-12)


def test_markers_may_be_named_in_import_yaml_one_system_for_each_recording(tmp_path, gappy):
    other = swing("swing_b")
    folder = lab_folder(tmp_path / "lab", gappy, other)
    write_c3d(folder / "swing_a.c3d", gappy)
    write_nexus(folder / "export.csv", other)
    change_import(folder, lambda c: c["recordings"]["swing_b"].update(markers={"kind": "nexus", "file": "export.csv"}))
    bundle = imported(folder, "c3d", "swing_a")
    same(bundle.recordings[1], other, 2e-9)


def test_labels_that_are_numbers_are_the_ids(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    for name in ("anchors.csv", "swing_a.csv"):
        if name == "swing_a.csv":
            write_long(folder / name, gappy)
        text = (folder / name).read_text()
        for k, label in enumerate(LABELS):
            text = text.replace(label, str(100 + k))
        (folder / name).write_text(text)
    change_import(folder, lambda c: c["markers"].update(labels="numbers", units="m"))
    assert imported(folder, "csv", "swing_a").anchors.marker.tolist() == list(range(100, 116))


def test_anchors_may_be_given_by_face_and_weights_in_the_file_or_in_a_table(tmp_path, gappy):
    ours = board_bundle(gappy).anchors
    folder = lab_folder(tmp_path / "lab", gappy)
    write_npz(folder / "swing_a.npz", gappy)
    columns = {"marker": LABELS, "face": ours.face} | {f"b{k}": ours.weight[:, k] for k in range(3)}
    pd.DataFrame(columns).to_csv(folder / "anchors.csv", index=False)
    np.testing.assert_array_equal(imported(folder, "npz", "swing_a").anchors.face, ours.face)
    listed = [
        {"marker": label, "face": int(face), "weights": weight.tolist()}
        for label, face, weight in zip(LABELS, ours.face, ours.weight, strict=True)
    ]
    change_import(folder, lambda c: c.update(anchors=listed[::-1]))
    again = imported(folder, "npz", "swing_a", force=True).anchors
    np.testing.assert_allclose(again.weight, ours.weight)
    np.testing.assert_array_equal(again.face, ours.face)


def test_a_mesh_in_millimetres_becomes_metres(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    write_npz(folder / "swing_a.npz", gappy)
    lines = [line.split() for line in (folder / "garment.obj").read_text().splitlines()]
    scaled = [[w[0], *(str(1000 * float(x)) for x in w[1:])] if w[0] != "f" else w for w in lines]
    (folder / "garment.obj").write_text("\n".join(" ".join(words) for words in scaled))
    with pytest.raises(BadInput, match=r"garment\.obj.*millimetres"):
        imported(folder, "npz", "swing_a")
    change_import(folder, lambda c: c["garment"].update(units="mm"))
    assert np.ptp(imported(folder, "npz", "swing_a").mesh.material_m) == pytest.approx(SIDE)


def test_a_marker_a_millimetre_beyond_the_hem_is_moved_onto_it_and_a_centimetre_beyond_is_refused(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    write_npz(folder / "swing_a.npz", gappy)
    anchors = pd.read_csv(folder / "anchors.csv")
    anchors.loc[0, "u_m"] = -0.001
    anchors.to_csv(folder / "anchors.csv", index=False)
    bundle = imported(folder, "npz", "swing_a")
    place = (bundle.mesh.material_m[bundle.mesh.faces[bundle.anchors.face[0]]] * bundle.anchors.weight[0][:, None]).sum(
        0
    )
    assert place == pytest.approx([0.0, anchors["v_m"][0]], abs=1e-3)
    anchors.loc[3, "u_m"] = SIDE + 0.01
    anchors.to_csv(folder / "anchors.csv", index=False)
    with pytest.raises(BadInput, match=r"anchors\.csv: row 5: marker 'cloth:M03'.*0\.01 m off the mesh"):
        imported(folder, "npz", "swing_a", force=True)
