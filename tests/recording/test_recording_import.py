"""A recording that went through the file of any system comes back as it was: units, axes, gaps, clocks, anchors."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import yaml
from lab_files import (
    LABELS,
    change_import,
    lab_folder,
    write_c3d,
    write_long,
    write_motive,
    write_nexus,
    write_npz,
    y_up,
)
from scipy.spatial.transform import Rotation
from swinging import ROW, SIDE, board_bundle, board_markers, swing
from typer.testing import CliRunner

from assets_defs._recordings import recordings as command
from sim1.recording.bundle import read_bundle
from sim1.recording.examination import examine
from sim1.recording.importing.c3d_file import read_c3d
from sim1.recording.importing.write import import_bundle
from sim1.stage import BadInput

WRITERS = {
    "motive": (write_motive, "csv", 2e-9),
    "nexus": (write_nexus, "csv", 2e-9),
    "csv": (write_long, "csv", 2e-6),
    "c3d": (write_c3d, "c3d", 1e-6),
    "npz": (write_npz, "npz", 1e-12),
}
FLOAT32_M = 1e-7  # the bundle's own rounding


@pytest.fixture
def gappy():
    recording = swing("swing_a", noise_m=5e-4)
    recording.markers_m[20:45, 3] = np.nan
    recording.markers_m[300, :] = np.nan
    recording.markers_m[-4:, 7] = np.nan
    return recording


def imported(folder, kind, *names, **options):
    files = [folder / f"{name}.{WRITERS[kind][1]}" for name in names]
    return import_bundle(kind, files, folder / "bundle", **options).bundle


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


def _edit(edit):
    return lambda folder: change_import(folder, edit)


def _replace(name, old, new):
    return lambda folder: (folder / name).write_text((folder / name).read_text().replace(old, new, 1))


def _of(content):
    return content["recordings"]["swing_a"]


FAULTS = {
    "a key that does not exist": (_edit(lambda c: c.update(colour="red")), r"import\.yaml: colour"),
    "a name that is no path": (_edit(lambda c: c["garment"].update(mesh="\x00")), r"import\.yaml: garment\.mesh"),
    "a shift beyond the lab": (
        _edit(lambda c: c["markers"].update(to_world={"shift_m": [1e300, 0, 0]})),
        r"import\.yaml: markers\.to_world\.shift_m",
    ),
    "a quaternion that is not unit": (
        _edit(lambda c: c["markers"].update(to_world={"rotation_wxyz": [1, 1, 0, 0]})),
        r"import\.yaml: markers\.to_world\.rotation_wxyz has length 1\.414",
    ),
    "a truth value": (_edit(lambda c: _of(c)["holds"][0].update(from_s=True)), r"import\.yaml.*truth value"),
    "two labels with one id": (
        _edit(lambda c: c["markers"]["labels"].update({LABELS[3]: 1})),
        r"import\.yaml.*one id, 1",
    ),
    "anchors: nearest": (_edit(lambda c: c.update(anchors="nearest")), r"import\.yaml.*mirror image.*u_m, v_m"),
    "a label that no file has": (
        _edit(lambda c: c["markers"]["labels"].update(elbow=77)),
        r"no anchor for marker 'elbow'",
    ),
    "a prior in grams": (
        _edit(lambda c: c["garment"]["prior"]["area_density_kg_m2"].update(value=200.0)),
        r"import\.yaml.*area_density",
    ),
    "a recording without a file": (
        _edit(lambda c: c["recordings"].update(swing_c=_of(c))),
        r"import\.yaml: recordings\.swing_c.*nowhere",
    ),
    "a hold of an unknown drive": (
        _edit(lambda c: _of(c)["holds"][0].update(drive="left")),
        r"drive 'left'; there are \['bar'\]",
    ),
    "a vertex that the mesh has not": (
        _edit(lambda c: _of(c)["holds"][0].update(vertices=[0, 99], places_m=None)),
        r"bundle\.yaml.*vertex 99",
    ),
    "a cut that leaves nothing": (_edit(lambda c: _of(c).update(cut_s=[50.0, 60.0])), r"swing_a\.csv runs from 0\.000"),
    "a cut that ends before it begins": (_edit(lambda c: _of(c).update(cut_s=[2.0, 1.0])), r"cut_s is \[2\.0, 1\.0\]"),
    "a marker with two anchors": (
        _replace("anchors.csv", LABELS[1], LABELS[0]),
        r"anchors\.csv: marker 'cloth:M00' has two",
    ),
    "an empty cell of an anchor": (_replace("anchors.csv", "0.0375,", ","), r"anchors\.csv: row 2: a cell is empty"),
    "a word in the data": (
        _replace("swing_a.csv", "\n0.020000,cloth:M00,-0.11", "\n0.020000,cloth:M00,-0.11x"),
        r"swing_a\.csv: row 34: '-0\.11x",
    ),
    "a marker twice at a time": (
        _replace("swing_a.csv", "0.000000,cloth:M01", "0.000000,cloth:M00"),
        r"swing_a\.csv: row \d: marker 'cloth:M00' occurs twice",
    ),
    "a header of another file": (_replace("swing_a.csv", "time_s,marker", "t,name"), r"swing_a\.csv: row 1: columns"),
    "drives without a column": (_replace("swing_a_drives.csv", "qw", "q0"), r"swing_a_drives\.csv.*missing \['qw'\]"),
    "drives that jump": (
        _replace("swing_a_drives.csv", "\n0.5,bar,0.0,0.0,", "\n0.5,bar,0.9,0.0,"),
        r"swing_a_drives\.csv.*jumps",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_named_and_nothing_is_written(tmp_path, gappy, fault):
    folder = lab_folder(tmp_path / "lab", gappy)
    write_long(folder / "swing_a.csv", gappy)
    do, words = FAULTS[fault]
    do(folder)
    with pytest.raises(BadInput, match=f"(?s){words}"):
        imported(folder, "csv", "swing_a", units="m")
    assert sorted(path.name for path in folder.iterdir() if "bundle" in path.name) == []


def test_a_unit_is_asked_for_where_nobody_says_it_and_refused_where_it_contradicts(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    write_long(folder / "swing_a.csv", gappy)
    with pytest.raises(BadInput, match=r"swing_a\.csv.*--units"):
        imported(folder, "csv", "swing_a")
    write_c3d(folder / "swing_a.c3d", gappy)
    with pytest.raises(BadInput, match=r"swing_a\.c3d.*'mm'.*'m'"):
        imported(folder, "c3d", "swing_a", units="m")
    write_c3d(folder / "swing_a.c3d", gappy, unit="furlong")
    with pytest.raises(BadInput, match=r"swing_a\.c3d.*furlong"):
        imported(folder, "c3d", "swing_a")


def test_millimetres_that_are_called_metres_are_found_out(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    write_long(folder / "swing_a.csv", gappy, scale=1000.0)
    with pytest.raises(BadInput, match="millimetres"):
        imported(folder, "csv", "swing_a", units="m")


@pytest.mark.parametrize("kind", WRITERS)
def test_files_cut_short_or_of_another_kind_are_refused_by_name(tmp_path, gappy, kind):
    write, ending, _ = WRITERS[kind]
    folder = lab_folder(tmp_path / "lab", gappy)
    path = folder / f"swing_a.{ending}"
    write(path, gappy)
    whole = path.read_bytes()
    for damaged in (b"", b"\xff\xfe\x00", whole[:40], whole[: len(whole) // 2], b"a,b\n1,2\n"):
        path.write_bytes(damaged)
        if kind in ("csv", "nexus") and damaged == whole[: len(whole) // 2]:
            continue  # a shorter table is a shorter recording
        with pytest.raises(BadInput, match=rf"swing_a\.{ending}|drive is shorter"):
            imported(folder, kind, "swing_a", units=None if kind != "csv" else "m")
    path.unlink()
    with pytest.raises(BadInput, match=rf"swing_a\.{ending}"):
        imported(folder, kind, "swing_a")


def test_a_file_on_which_the_library_itself_breaks_down_is_refused_too(tmp_path):
    path = tmp_path / "swing.c3d"
    write_c3d(path, swing("a", moves_s=0.3, rest_s=0.2, rate_hz=30.0))
    whole, stream = path.read_bytes(), np.random.default_rng(0)
    refused = 0
    for _ in range(12):
        scrambled = bytearray(whole)
        for at in stream.integers(0, 1024, 12):
            scrambled[at] = stream.integers(0, 256)
        path.write_bytes(bytes(scrambled))
        try:
            read_c3d(path, "mm")
        except BadInput as error:
            refused += "swing.c3d" in str(error)
    assert refused > 3


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"positions": np.zeros((3, 2))}, "expected"),
        ({"labels": None}, "no key 'labels'"),
        ({"extra": 1}, "'extra' is unknown"),
        ({"visible": np.ones(3)}, "visible"),
        ({"time_s": np.array(["a"])}, "expected numbers"),
        ({"drive_bar_open": np.zeros(2)}, "drive_bar_open"),
        ({"drive_bar_position_m": None}, "no key 'drive_bar_position_m'"),
    ],
)
def test_an_archive_with_other_arrays_is_refused_by_key(tmp_path, gappy, changes, words):
    folder = lab_folder(tmp_path / "lab", gappy)
    change_import(folder, lambda c: c["recordings"]["swing_a"].update(drives={"kind": "npz"}))
    write_npz(folder / "swing_a.npz", gappy, **changes)
    with pytest.raises(BadInput, match=words):
        imported(folder, "npz", "swing_a")


def test_a_bundle_that_is_there_is_kept_unless_one_says_force(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    write_npz(folder / "swing_a.npz", gappy)
    imported(folder, "npz", "swing_a")
    change_import(folder, lambda c: c["markers"].update(noise_std_m=0.002))
    with pytest.raises(BadInput, match="--force"):
        imported(folder, "npz", "swing_a")
    assert read_bundle(folder / "bundle").noise_std_m is None
    write_npz(folder / "swing_a.npz", gappy, positions=gappy.markers_m * 1000)
    with pytest.raises(BadInput, match="millimetres"):
        imported(folder, "npz", "swing_a", force=True)
    assert read_bundle(folder / "bundle").noise_std_m is None
    write_npz(folder / "swing_a.npz", gappy)
    imported(folder, "npz", "swing_a", force=True)
    assert read_bundle(folder / "bundle").noise_std_m == 0.002
    assert [path.name for path in folder.iterdir() if path.name.startswith(".")] == []


def test_force_does_not_replace_what_is_not_a_bundle(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    write_npz(folder / "swing_a.npz", gappy)
    (folder / "bundle").mkdir()
    (folder / "bundle/diary.txt").write_text("mine")
    with pytest.raises(BadInput, match="not a bundle"):
        imported(folder, "npz", "swing_a", force=True)
    assert (folder / "bundle/diary.txt").read_text() == "mine"


def test_the_command_imports_and_says_what_it_left_out(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    write_motive(folder / "swing_a.csv", gappy)
    words = ["import", "motive", str(folder / "swing_a.csv"), "--out", str(tmp_path / "out/bundle")]
    result = CliRunner().invoke(command, words)
    assert result.exit_code == 0, result.output
    assert "Unlabeled 1189" in result.output
    assert len(read_bundle(tmp_path / "out/bundle").recordings) == 1
    again = CliRunner().invoke(command, words)
    assert again.exit_code == 2
    assert "--force" in again.output
    assert CliRunner().invoke(command, [*words, "--force", "--up", "x"]).exit_code == 2
    (folder / "import.yaml").unlink()
    assert "import.yaml" in CliRunner().invoke(command, [*words, "--force"]).output


def test_the_example_of_the_documentation_is_a_valid_import_file(tmp_path):
    from pathlib import Path

    from sim1.recording.importing.import_file import read_import_file

    text = (Path(__file__).parents[2] / "docs/recordings.md").read_text()
    [example] = [part.split("```")[0] for part in text.split("```yaml")[1:] if "sim1.import/1" in part]
    (tmp_path / "import.yaml").write_text(example)
    document = read_import_file(tmp_path / "import.yaml")
    assert yaml.safe_load(example)["recordings"].keys() == document.recordings.keys()
    assert (
        max(vertex for part in document.recordings.values() for hold in part.holds for vertex in hold.vertices)
        > ROW - 2
    )
