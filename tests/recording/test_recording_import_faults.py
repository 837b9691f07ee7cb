"""Faults of a lab's files are named, and nothing is written; what is there stays unless one says otherwise."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
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
    write_npz,
)
from swinging import ROW, swing
from typer.testing import CliRunner

from assets_defs._recordings import recordings as command
from sim1.recording.bundle import read_bundle
from sim1.recording.importing.c3d_file import read_c3d
from sim1.stage import BadInput


@pytest.fixture
def gappy():
    return gappy_swing()


def _edit(edit):
    return lambda folder: change_import(folder, edit)


def _replace(name, old, new):
    return lambda folder: (folder / name).write_text((folder / name).read_text().replace(old, new, 1))


def _keep(name, rows):
    return lambda folder: (folder / name).write_text("\n".join((folder / name).read_text().split("\n")[:rows]))


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
        r"import\.yaml: recording swing_a: .*vertex 99",
    ),
    "a cut that leaves nothing": (_edit(lambda c: _of(c).update(cut_s=[50.0, 60.0])), r"swing_a\.csv runs from 0\.000"),
    "a cut that ends before it begins": (_edit(lambda c: _of(c).update(cut_s=[2.0, 1.0])), r"cut_s is \[2\.0, 1\.0\]"),
    "a marker with two anchors": (
        _replace("anchors.csv", LABELS[1], LABELS[0]),
        r"anchors\.csv: row 3: marker 'cloth:M00' has two",
    ),
    "an empty cell of an anchor": (_replace("anchors.csv", "0.0375,", ","), r"anchors\.csv: row 2: a cell is empty"),
    "no anchors": (_keep("anchors.csv", 1), r"anchors\.csv: no rows below the header"),
    "an anchor beyond all numbers": (
        _replace("anchors.csv", ",0.0375,", ",1e300,"),
        r"anchors\.csv: row 2: marker 'cloth:M00' at \[1e\+300, .* off the mesh",
    ),
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
        ({"drive_bar_position_m": np.zeros((3, 450))}, r"drive_bar_position_m is \(3, 450\); expected \(450, 3\)"),
        ({"drive_bar_time_s": np.zeros(0)}, "drive_bar_time_s is empty"),
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


def test_a_place_that_cannot_be_written_to_is_named(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    write_npz(folder / "swing_a.npz", gappy)
    (tmp_path / "notes.txt").write_text("mine")
    words = ["import", "npz", str(folder / "swing_a.npz"), "--out", str(tmp_path / "notes.txt/bundle")]
    result = CliRunner().invoke(command, words)
    assert result.exit_code == 2, result.output
    assert "notes.txt: cannot be written to" in result.output
    assert (tmp_path / "notes.txt").read_text() == "mine"


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


def test_the_command_names_all_that_is_wrong(tmp_path, gappy):
    folder = lab_folder(tmp_path / "lab", gappy)
    change_import(folder, lambda c: _of(c)["drives"].update(shift_s=7200.0))
    change_import(folder, lambda c: c["markers"].update(units="m"))
    write_long(folder / "swing_a.csv", replace(gappy, time_s=gappy.time_s + 7200.0))
    words = ["import", "csv", str(folder / "swing_a.csv"), "--out", str(tmp_path / "bundle")]
    said = CliRunner().invoke(command, words).output
    assert "swing_a_drives.csv: row 2: time_s is 7200" in said
    assert "swing_a.csv: row 2: time_s is 7200" in said


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
