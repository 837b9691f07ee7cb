"""Whatever is wrong with a lab's files, the message names the lab's own file and the row or frame in it."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from lab_files import LABELS, WRITERS, change_import, imported, lab_folder, write_long, write_motive, write_npz
from swinging import ROW, board_bundle, swing

from sim1.recording.importing.drive_table import read_drive_table
from sim1.recording.importing.npz_file import read_npz_drives
from sim1.stage import BadInput

FRAME, MARKER = 200, 5  # where the fault is
STANDS = {  # for messages: rows of text from 1 below each header, frames of C3D from 1, of arrays from 0
    "motive": f"swing_a.csv: row {8 + FRAME}",
    "nexus": f"swing_a.csv: row {13 + FRAME}",
    "csv": f"swing_a.csv: row {2 + 16 * FRAME + MARKER}",
    "c3d": f"swing_a.c3d: frame {1 + FRAME}",
    "npz": f"swing_a.npz: frame {FRAME}",
}


def refusal(folder, kind) -> str:
    """Why an import is refused; nothing of it is ever there, and no message speaks of it."""
    with pytest.raises(BadInput) as error:
        imported(folder, kind, "swing_a", units="m" if kind == "csv" else None)
    assert not any("bundle" in path.name for path in folder.iterdir())
    assert "recordings/" not in str(error.value)
    return str(error.value)


def with_marker_at(recording, place_m):
    markers = recording.markers_m.copy()
    markers[FRAME, MARKER] = place_m
    return replace(recording, markers_m=markers)


def written(folder, kind, recording):
    write, ending, _ = WRITERS[kind]
    write(lab_folder(folder, recording) / f"swing_a.{ending}", recording)
    return folder


@pytest.mark.parametrize("kind", WRITERS)
def test_a_marker_in_millimetres_is_named_where_it_stands(tmp_path, kind):
    recording = swing("swing_a")
    place = 1000 * recording.markers_m[FRAME, MARKER]
    said = refusal(written(tmp_path / "lab", kind, with_marker_at(recording, place)), kind)
    assert f"{STANDS[kind]}: at 2.0 s marker '{LABELS[MARKER]}'" in said
    assert "millimetres" in said


@pytest.mark.parametrize("kind", WRITERS)
def test_a_marker_elsewhere_in_the_room_is_named_by_its_frame(tmp_path, kind):
    """Found only as the bundle is read back, by its distance from the others."""
    said = refusal(written(tmp_path / "lab", kind, with_marker_at(swing("swing_a"), [3.0, 0.0, 0.8])), kind)
    assert (
        f"{STANDS[kind].replace(str(2 + 16 * FRAME + MARKER), str(2 + 16 * FRAME))}: at 2.0 s the markers span" in said
    )


@pytest.mark.parametrize("kind", WRITERS)
def test_a_number_that_is_not_finite_is_named_where_it_stands(tmp_path, kind):
    said = refusal(written(tmp_path / "lab", kind, with_marker_at(swing("swing_a"), [0.0, np.inf, 0.0])), kind)
    assert said.split("/")[-1].startswith(STANDS[kind])
    assert "inf" in said


@pytest.mark.parametrize("kind", ["motive", "nexus", "csv", "npz"])  # a C3D file has no time stamps
def test_a_clock_that_runs_back_is_named_where_it_does_also_outside_of_a_cut(tmp_path, kind):
    recording = swing("swing_a")
    late = np.arange(len(recording.time_s)) >= FRAME
    folder = written(tmp_path / "lab", kind, replace(recording, time_s=recording.time_s - np.where(late, 0.507, 0.0)))
    first = STANDS[kind].replace(str(2 + 16 * FRAME + MARKER), str(2 + 16 * FRAME))
    assert f"{first}: the clock runs back from 1.99 s to 1.4" in refusal(folder, kind)
    change_import(folder, lambda content: content["recordings"]["swing_a"].update(cut_s=[0.0, 1.2]))
    assert f"{first}: the clock runs back" in refusal(folder, kind)


def test_a_frame_without_a_time_is_named(tmp_path):
    recording = swing("swing_a")
    time = np.where(np.arange(len(recording.time_s)) == FRAME, np.nan, recording.time_s)
    folder = lab_folder(tmp_path / "lab", recording)
    write_npz(folder / "swing_a.npz", recording, time_s=time)
    assert "swing_a.npz: frame 200: time_s is nan" in refusal(folder, "npz")
    write_npz(folder / "swing_a.npz", recording, time_s=time[:0], positions=recording.markers_m[:0])
    assert "swing_a.npz: no frame" in refusal(folder, "npz")


def test_blank_lines_count_as_rows(tmp_path):
    recording = with_marker_at(swing("swing_a"), np.inf)
    folder = lab_folder(tmp_path / "lab", recording)
    write_motive(folder / "swing_a.csv", recording)
    text = (folder / "swing_a.csv").read_text().replace("\n100,1.000000,", "\n\n\n100,1.000000,")
    (folder / "swing_a.csv").write_text(text)
    assert f"swing_a.csv: row {8 + FRAME + 2}: " in refusal(folder, "motive")


DRIVE_FAULTS = {
    "millimetres": ({"z_m": 800.0}, r"drive 'bar' is at \[.*800\.0\] at 2\.0 s; .*millimetres"),
    "NaN": ({"y_m": np.nan}, "drive 'bar': y_m is nan, which is not finite"),
    "a clock that runs back": ({"time_s": 0.5}, "drive 'bar': the clock runs back from 1.99 s to 0.5 s"),
    "a jump": ({"x_m": 0.4}, "drive 'bar': the drive jumps by 0.4 m"),
    "a quaternion that is not unit": ({"qw": 0.5}, "drive 'bar': its quaternion has length 0.5"),
    "openness in per cent": ({"open": 57.0}, "drive 'bar': open is 57.0; expected 0"),
}


@pytest.mark.parametrize("fault", DRIVE_FAULTS)
@pytest.mark.parametrize("kind", ["csv", "parquet", "npz"])
def test_a_fault_of_a_drive_is_named_where_it_stands(tmp_path, kind, fault):
    values, words = DRIVE_FAULTS[fault]
    table = pd.read_csv(lab_folder(tmp_path / "lab", swing("swing_a")) / "swing_a_drives.csv")
    table.loc[FRAME, list(values)] = list(values.values())
    path = tmp_path / f"drives.{kind}"
    if kind == "csv":
        head, *lines = table.to_csv(index=False).splitlines()
        path.write_text("\n".join([head, "", *lines[:50], "  ", *lines[50:]]) + "\n")
        read, row = read_drive_table, FRAME + 4  # text counts from 1, header and blank lines too
    elif kind == "parquet":
        table.to_parquet(path)
        read, row = read_drive_table, FRAME
    else:
        of = {"time_s": "time_s", "position_m": ["x_m", "y_m", "z_m"], "rotation_wxyz": ["qw", "qx", "qy", "qz"]}
        parts = {part: table[columns].to_numpy() for part, columns in (of | {"open": "open"}).items()}
        np.savez(path, **{f"drive_bar_{part}": values for part, values in parts.items()})
        read, row = read_npz_drives, FRAME
    with pytest.raises(BadInput, match=rf"drives\.{kind}: row {row}: {words}"):
        read(path)


def test_a_table_of_drives_with_a_damaged_cell_is_refused_by_its_row(tmp_path):
    path = lab_folder(tmp_path / "lab", swing("swing_a")) / "swing_a_drives.csv"
    whole = path.read_text()
    for old, new, words in (
        ("\n0.5,bar,0.0,", "\n0.5,bar,zero,", "row 52: 'zero' is not a number; a command is always known"),
        ("\n0.5,bar,0.0,", "\n0.5,bar,,", "row 52: drive 'bar': x_m is nan"),
        ("\n0.5,bar,0.0,", "\n0.5,,0.0,", "row 52: no drive"),
        ("\n0.5,bar,0.0,", "\n0,5,bar,0.0,", "row 52: 11 cells for 10 columns"),
        (whole[whole.index("\n") :], "\n", "no rows below the header"),
    ):
        path.write_text(whole.replace(old, new, 1))
        with pytest.raises(BadInput, match=rf"swing_a_drives\.csv: {words}"):
            read_drive_table(path)


@pytest.mark.parametrize(
    ("drives", "words"),
    [
        ({"kind": "csv", "file": "gone.csv"}, "gone.csv: not readable"),
        ({"kind": "csv", "file": "gone.parquet"}, "gone.parquet: missing stream"),
        ({"kind": "npz", "file": "gone.npz"}, "gone.npz: not a readable .npz"),
        ({"kind": "lerobot", "file": "gone", "episode": 0}, "import.yaml: recordings.swing_a.drives"),
    ],
)
def test_a_missing_stream_is_refused_by_name(tmp_path, drives, words):
    folder = written(tmp_path / "lab", "npz", swing("swing_a"))
    change_import(folder, lambda content: content["recordings"]["swing_a"].update(drives=drives))
    assert words in refusal(folder, "npz")


def _anchors(edit):
    def do(folder):
        ours = board_bundle(swing("swing_a")).anchors
        columns = {"marker": LABELS, "face": ours.face} | {f"b{k}": ours.weight[:, k] for k in range(3)}
        table = pd.DataFrame(columns)
        edit(table)
        table.to_csv(folder / "anchors.csv", index=False)

    return do


def _listed(folder):
    ours = board_bundle(swing("swing_a")).anchors
    anchors = [
        {"marker": label, "face": int(face), "weights": weight.tolist()}
        for label, face, weight in zip(LABELS, ours.face, ours.weight, strict=True)
    ]
    anchors[2]["weights"] = [1.5, -0.5, 0.0]
    change_import(folder, lambda content: content.update(anchors=anchors))


def _weights(table):
    table.loc[4, ["b0", "b1", "b2"]] = [1.5, -0.5, 0.0]


def _part(edit):
    return lambda folder: change_import(folder, lambda content: edit(content["recordings"]["swing_a"]))


def _shifted_drives(folder):
    drives = pd.read_csv(folder / "swing_a_drives.csv")
    drives.assign(z_m=drives["z_m"] + 80.0 - drives["time_s"] / 100).to_csv(folder / "swing_a_drives.csv", index=False)


def _setting_off(folder):
    drives = pd.read_csv(folder / "swing_a_drives.csv")
    drives.assign(x_m=drives["x_m"] + 0.1 * drives["time_s"]).to_csv(folder / "swing_a_drives.csv", index=False)


def _far_mesh(folder):
    """A mesh so far off that two of its vertices are one as they are written again."""
    lines = (folder / "garment.obj").read_text().splitlines()
    x, y = ([9e5 + float(line.split()[axis]) for line in lines[: ROW**2]] for axis in (1, 2))
    x[7], y[7] = x[0] + 3e-4, y[0] + 3e-4
    moved = [f"v {one:.9f} {other:.9f} 0" for one, other in zip(x, y, strict=True)]
    (folder / "garment.obj").write_text("\n".join([*moved, *lines[ROW**2 :]]))


FOUND_READING_BACK = {
    "a face that the mesh has not": (
        _anchors(lambda table: table.__setitem__("face", table["face"].replace(table["face"][3], 99))),
        "anchors.csv: row 5: marker 'cloth:M03': off the mesh: face 99 of 50",
    ),
    "weights outside the face": (
        _anchors(_weights),
        "anchors.csv: row 6: marker 'cloth:M04': marker off the mesh: barycentric [1.5, -0.5, 0.0]",
    ),
    "weights outside, in the list": (_listed, "import.yaml: anchors.2: marker 'cloth:M02': marker off the mesh"),
    "drives in another frame": (_shifted_drives, "swing_a_drives.csv: row 451: the drives stay"),
    "a start that is none": (_setting_off, "swing_a_drives.csv: row 6: import.yaml says that the recording starts"),
    "drives on another clock": (
        _part(lambda part: part["drives"].update(shift_s=7200.0)),
        "swing_a_drives.csv: row 2: time_s is 7200",
    ),
    "a cut where there are no drives": (
        _part(lambda part: (part["drives"].update(shift_s=-4.0), part.update(cut_s=[2.0, 3.0]))),
        "swing_a.npz: markers run from 2.000 to 3.000 s and drive 'bar' from 0.480",
    ),
    "a hold that never begins": (
        _part(lambda part: part["holds"][0].update(from_s=50.0, to_s=60.0)),
        "import.yaml: recording swing_a: hold of drive 'bar': 50.0 to 60.0 s lies outside",
    ),
    "noise in millimetres": (
        lambda folder: change_import(folder, lambda content: content["markers"].update(noise_std_m=0.8)),
        "import.yaml: markers.noise_std_m is 0.8",
    ),
    "a mesh that does not come back": (_far_mesh, "garment.obj: vertices 0 and 7 are at the same place"),
}


@pytest.mark.parametrize("fault", FOUND_READING_BACK)
def test_what_is_found_reading_back_is_named_by_the_file_that_was_given(tmp_path, fault):
    folder = written(tmp_path / "lab", "npz", swing("swing_a"))
    do, words = FOUND_READING_BACK[fault]
    do(folder)
    assert f"{folder}/{words}" in refusal(folder, "npz")


def test_a_mesh_without_material_coordinates_is_named_where_they_are_measured_along(tmp_path):
    folder = written(tmp_path / "lab", "npz", swing("swing_a"))
    lines = [line.split() for line in (folder / "garment.obj").read_text().splitlines()]
    bare = [" ".join(word.split("/")[0] for word in words) for words in lines if words[0] != "vt"]
    (folder / "garment.obj").write_text("\n".join(bare))
    assert "garment.obj: no `vt`, along which" in refusal(folder, "npz")


def test_rows_of_a_plain_table_are_those_of_the_marker_also_where_others_are_missing(tmp_path):
    recording = swing("swing_a")
    recording.markers_m[:FRAME, 3] = np.nan
    folder = lab_folder(tmp_path / "lab", recording)
    write_long(folder / "swing_a.csv", with_marker_at(recording, [800.0, 0.0, 0.0]))
    lines = (folder / "swing_a.csv").read_text().splitlines()
    row = next(k for k, line in enumerate(lines, start=1) if ",800.0" in line)
    assert f"swing_a.csv: row {row}: " in refusal(folder, "csv")


@pytest.mark.parametrize("file", ["anchors.csv", "swing_a.csv"])
def test_a_row_with_more_cells_than_columns_is_refused_and_not_read_in_part(tmp_path, file):
    """Decimal commas, as some systems export them."""
    folder = written(tmp_path / "lab", "csv", swing("swing_a"))
    head, first, *lines = (folder / file).read_text().splitlines()
    (folder / file).write_text("\n".join([head, f"{first},5", *lines]) + "\n")
    count = len(head.split(","))
    assert f"{file}: row 2: {count + 1} cells for {count} columns" in refusal(folder, "csv")


def test_what_was_imported_says_that_it_lies_where_it_was_put(tmp_path):
    folder = written(tmp_path / "lab", "npz", swing("swing_a"))
    assert imported(folder, "npz", "swing_a").folder == folder / "bundle"
