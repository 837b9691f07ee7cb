"""Each harm that a lab can do to a bundle, and the words in which it is refused."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from test_recording_bundle import DRIVES, FRAMES, MARKERS, change, change_yaml, small_bundle

from sim1.recording.bundle import examine_bundle, read_bundle, write_bundle
from sim1.stage import BadInput

ANCHORS = "anchors.parquet"


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    folder = tmp_path_factory.mktemp("damage") / "good"
    write_bundle(folder, small_bundle())
    return folder


@pytest.fixture
def folder(good, tmp_path):
    return Path(shutil.copytree(good, tmp_path / "b"))


def _with(file, edit):
    return lambda folder: change(folder / file, edit)


def _mesh(old, new):
    return lambda folder: (folder / "garment.obj").write_text((folder / "garment.obj").read_text().replace(old, new))


def _yaml(edit):
    return lambda folder: change_yaml(folder, edit)


def _hold(content):
    return content["recordings"][1]["holds"][0]


def _line(text):
    return lambda folder: (folder / "bundle.yaml").write_text(text + (folder / "bundle.yaml").read_text())


def _in_milliseconds(folder):
    for file in (MARKERS, DRIVES):
        change(folder / file, lambda table: table.assign(time_s=table["time_s"] * 1000))


def _since_1970(table):
    return table.assign(time_s=table["time_s"] + 1.7e9)


def _late(table):
    return table.assign(time_s=table["time_s"] + 1.0)


def _lone_jump(table):
    table.loc[7:, "x_m"] += 0.08  # 8 m/s for one sample: within an arm's speed, and yet no arm does it


def _gap(table):
    return table[(table["time_s"] < 0.02) | (table.index == len(table) - 1)].assign(
        time_s=lambda t: np.where(t["time_s"] > 0.02, t["time_s"] + 0.6, t["time_s"])
    )


def _one_marker_away(table):
    table.loc[table.index % 3 != 0, "visible"] = False
    table.loc[6, "x_m"] = 30.0


HARM = {
    "a folder that is not listed": (
        lambda f: (f / "recordings/c").mkdir(),
        r"bundle\.yaml.*recordings/c is not listed",
    ),
    "a key twice": (_line("schema: sim1.recordings/1\n"), r"bundle\.yaml.*'schema' occurs twice"),
    "a truth value for a number": (_yaml(lambda c: _hold(c).update(to_s=True)), r"bundle\.yaml.*truth value"),
    "std and log_std": (
        _yaml(lambda c: c["garment"]["prior"]["stretch_n_m"].update(std=1.0)),
        r"bundle\.yaml.*stretch_n_m.*keep one",
    ),
    "gravity along y": (_yaml(lambda c: c["environment"].update(gravity_m_s2=[0, -9.81, 0])), r"bundle\.yaml.*z is up"),
    "noise in millimetres": (_yaml(lambda c: c["markers"].update(noise_std_m=0.8)), r"bundle\.yaml.*noise_std_m"),
    "places in millimetres": (
        _yaml(lambda c: _hold(c).update(places_m=[[0, 0, 0], [300, 0, 0]])),
        r"bundle\.yaml.*places_m",
    ),
    "places in centimetres": (
        _yaml(lambda c: _hold(c).update(places_m=[[0, 0, 0], [1.5, 0, 0]])),
        r"bundle\.yaml.*places_m",
    ),
    "a table above the cloth": (
        _yaml(lambda c: c["environment"].update(table={"height_m": 2.0, "friction": {"value": 0.4}})),
        r"markers\.parquet.*below the table",
    ),
    "stamps in milliseconds": (_in_milliseconds, r"drives\.parquet.*milliseconds"),
    "stamps of a computer's clock": (
        lambda f: [change(f / file, _since_1970) for file in (MARKERS, DRIVES)],
        r"drives\.parquet.*row 0: time_s is 1700000000; expected seconds from the start.*subtract one and the same stamp",
    ),
    "markers stamped by a computer's clock": (
        _with(MARKERS, _since_1970),
        r"markers\.parquet.*row 0: time_s is 1700000000; expected seconds from the start",
    ),
    "rows of a marker that go back in time": (
        _with(MARKERS, lambda t: t.sort_values(["marker", "time_s"], ascending=[True, False])),
        r"markers\.parquet: row 1: the clock runs back .* for marker 2; sort",
    ),
    "a frame stamped twice": (
        _with(
            MARKERS, lambda t: t.assign(time_s=t["time_s"].replace(t["time_s"].unique()[5], t["time_s"].unique()[4]))
        ),
        r"markers\.parquet.*2 rows of marker",
    ),
    "two frames nearly at once": (
        _with(
            MARKERS,
            lambda t: t.assign(time_s=t["time_s"].replace(t["time_s"].unique()[5], t["time_s"].unique()[4] + 1e-9)),
        ),
        r"markers\.parquet.*stands still",
    ),
    "drives that start late": (_with(DRIVES, _late), r"outside the recording \(1\.000 to"),
    "drives that end early": (
        lambda f: (
            change(f / MARKERS, lambda t: t.assign(time_s=t["time_s"] * 3)),
            change_yaml(f, lambda c: _hold(c).update(to_s=0.3)),
        ),
        r"drives\.parquet.*shorter than the markers",
    ),
    "a lone jump": (_with(DRIVES, _lone_jump), r"drives\.parquet.*row 7.*jumps"),
    "a gap in the commands": (_with(DRIVES, _gap), r"drives\.parquet.*no command for"),
    "a lone marker far away": (_with(MARKERS, _one_marker_away), r"markers\.parquet.*marker 2 is 3\d"),
    "anchors of another cloth": (
        _with(MARKERS, lambda t: t.assign(y_m=0.0, z_m=0.0, x_m=np.tile([0.0, 0.23, 0.45], FRAMES))),
        r"markers\.parquet.*times as far apart",
    ),
    "metres said to be millimetres": (
        _with(MARKERS, lambda t: t.assign(**{axis: t[axis] / 1000 for axis in ("x_m", "y_m", "z_m")})),
        r"markers\.parquet: markers never span more than 0\.00\d+ of .* said to be in millimetres",
    ),
    "all markers in one place": (
        _with(MARKERS, lambda t: t.assign(x_m=0.1, y_m=0.2, z_m=0.3)),
        r"markers\.parquet: markers never span more than 0 of",
    ),
    "a negative marker id": (_with(ANCHORS, lambda t: t.assign(marker=[-2, 5, 7])), r"anchors\.parquet.*marker id -2"),
    "a face without area": (_mesh("v 0.3 0.3 0", "v 0.15 0 0"), r"garment\.obj.*no area"),
    "a face of one vertex twice": (_mesh("f 1/1 2/2 3/3", "f 1/1 2/2 2/2"), r"garment\.obj.*(no area|no face)"),
    "a face twice": (_mesh("f 1/1 2/2 3/3\n", "f 1/1 2/2 3/3\nf 2/2 3/3 1/1\n"), r"garment\.obj.*occurs twice"),
    "a vertex twice": (_mesh("vt 0 0\n", "v 0.3 0.3 0\nvt 0 0\n"), r"garment\.obj.*same place"),
    "a vertex in no face": (_mesh("vt 0 0\n", "v 0.1 0.3 0.1\nvt 0 0\n"), r"garment\.obj.*vertex 4 belongs to no face"),
    "a texture from 0 to 1": (
        _mesh("vt 0.3 0\nvt 0.3 0.3\nvt 0 0.3", "vt 1 0\nvt 1 1\nvt 0 1"),
        r"garment\.obj.*`vt` are 3\.33 times",
    ),
    "vt squeezed along one side": (
        _mesh("vt 0.3 0\nvt 0.3 0.3", "vt 0.1 0\nvt 0.1 0.3"),
        r"garment\.obj.*`vt`",
    ),
    "half a material coordinate": (_mesh("vt 0.3 0.3", "vt 0.3"), r"garment\.obj:\d+.*expected 2"),
    "a corner without material": (_mesh("f 1/1 2/2 3/3", "f 1/1 2/2 3"), r"garment\.obj.*face 0 has no `vt`"),
    "relative indices": (_mesh("f 1/1 2/2 3/3", "f -4/1 -3/2 -2/3"), r"garment\.obj:\d+.*not supported"),
}


@pytest.mark.parametrize("harm", HARM)
def test_a_harmed_bundle_is_refused_with_file_value_and_remedy(folder, harm):
    do, words = HARM[harm]
    do(folder)
    with pytest.raises(BadInput, match=f"(?s){words}"):
        read_bundle(folder)


@pytest.mark.parametrize("by", [["marker", "time_s"], ["time_s", "marker"]])
def test_rows_may_come_frame_by_frame_or_marker_by_marker(folder, by):
    before = read_bundle(folder).recordings[1]
    change(folder / MARKERS, lambda table: table.sort_values(by))
    after = read_bundle(folder).recordings[1]
    np.testing.assert_array_equal(after.time_s, before.time_s)
    np.testing.assert_array_equal(after.markers_m, before.markers_m)


def test_the_examination_names_what_is_wrong_in_every_file(folder):
    for do, _ in (
        HARM["a face twice"],
        HARM["a negative marker id"],
        HARM["a lone jump"],
        HARM["two frames nearly at once"],
    ):
        do(folder)
    bundle, problems = examine_bundle(folder)
    assert bundle is None
    assert len(problems) == 3  # without anchors, markers cannot be told


def test_the_examination_names_every_fault_of_bundle_yaml(folder):
    HARM["noise in millimetres"][0](folder)
    HARM["std and log_std"][0](folder)
    HARM["gravity along y"][0](folder)
    assert len(examine_bundle(folder)[1]) == 3
