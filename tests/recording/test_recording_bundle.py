import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sim1.recording.bundle import Bundle, Hold, Recording, read_bundle, write_bundle
from sim1.recording.document import Environment, Prior, Priors
from sim1.recording.mesh import RestMesh
from sim1.recording.streams import Anchors, Track
from sim1.stage import BadInput

FRAMES, SAMPLES = 12, 40


def small_bundle() -> Bundle:
    """Two triangles of 0.3 m, three markers, one drive that moves 0.1 m in 0.4 s."""
    corners = np.array([[0, 0], [0.3, 0], [0.3, 0.3], [0, 0.3]])
    mesh = RestMesh(
        vertices_m=np.column_stack([corners, np.zeros(4)]), faces=np.array([[0, 1, 2], [0, 2, 3]]), material_m=corners
    )
    anchors = Anchors(
        marker=np.array([2, 5, 7]), face=np.array([0, 1, 1]), weight=np.array([[1, 0, 0], [0.2, 0.3, 0.5], [0, 0, 1]])
    )
    time = np.linspace(0, 0.4, SAMPLES)
    quaternion = np.column_stack([np.cos(time), 0 * time, 0 * time, np.sin(time)])
    track = Track(
        time_s=time,
        position_m=np.column_stack([0 * time, 0.25 * time, 0.5 + 0 * time]),
        rotation_wxyz=quaternion,
        openness=0 * time,
    )
    frames = np.linspace(0, 0.4, FRAMES)
    markers = np.zeros((FRAMES, 3, 3)) + np.array([[0.0, 0, 0.5], [0.1, 0, 0.4], [0.0, 0.0, 0.2]])
    markers[3, 1] = np.nan
    hold = Hold(
        drive="left", vertices=np.array([0, 1]), from_s=0.0, to_s=0.4, places_m=np.array([[0, 0, 0], [0.3, 0, 0]])
    )
    recordings = tuple(
        Recording(name=name, starts="moving", holds=(hold,), time_s=frames, markers_m=markers, drives={"left": track})
        for name in ("swing_a", "b")
    )
    priors = {name: Prior(value=0.1, log_std=0.5) for name in Priors.model_fields} | {"thickness_m": Prior(value=0.001)}
    environment = Environment(gravity_m_s2=(0, 0, -9.81), air_density_kg_m3=1.2, table=None)
    return Bundle(
        mesh=mesh,
        prior=Priors(**priors),
        environment=environment,
        noise_std_m=None,
        anchors=anchors,
        recordings=recordings,
    )


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bundle") / "good"
    write_bundle(folder, small_bundle())
    return folder


@pytest.fixture
def folder(good, tmp_path):
    return Path(shutil.copytree(good, tmp_path / "b"))


def change(path: Path, edit) -> None:
    table = pd.read_parquet(path)
    result = edit(table)
    (table if result is None else result).to_parquet(path, index=False)


def change_yaml(folder: Path, edit) -> None:
    content = yaml.safe_load((folder / "bundle.yaml").read_text())
    edit(content)
    (folder / "bundle.yaml").write_text(yaml.safe_dump(content))


def test_a_bundle_reads_back_as_it_was_written(folder):
    ours, back = small_bundle(), read_bundle(folder)
    assert back.prior == ours.prior
    assert back.environment == ours.environment
    np.testing.assert_array_equal(back.mesh.faces, ours.mesh.faces)
    np.testing.assert_allclose(back.mesh.material_m, ours.mesh.material_m)
    np.testing.assert_array_equal(back.anchors.marker, ours.anchors.marker)
    for one, other in zip(back.recordings, ours.recordings, strict=True):
        np.testing.assert_allclose(one.markers_m, other.markers_m, atol=1e-7)
        np.testing.assert_allclose(one.drives["left"].rotation_wxyz, other.drives["left"].rotation_wxyz)
        np.testing.assert_allclose(one.holds[0].places_m, other.holds[0].places_m)
        assert one.seen.sum() == other.seen.sum() == 3 * FRAMES - 1


def test_writing_a_bundle_twice_gives_the_same_bytes(folder, tmp_path):
    write_bundle(tmp_path / "again", read_bundle(folder))
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            assert (tmp_path / "again" / path.relative_to(folder)).read_bytes() == path.read_bytes()


def test_a_quaternion_that_changes_sign_is_the_same_rotation(folder):
    path = folder / "recordings/b/drives.parquet"

    def flip(table):
        table.loc[10:, ["qw", "qx", "qy", "qz"]] *= -1

    change(path, flip)
    turned = read_bundle(folder).recordings[1].drives["left"].rotation_wxyz
    np.testing.assert_allclose(turned, small_bundle().recordings[1].drives["left"].rotation_wxyz)


MARKERS, DRIVES = "recordings/b/markers.parquet", "recordings/b/drives.parquet"


def _set(row, column, value):
    def edit(table):
        table[column] = table[column].astype(float) if isinstance(value, float) else table[column]
        table.loc[row, column] = value

    return edit


def _scale(*columns):
    def edit(table):
        table[list(columns)] *= 1000

    return edit


def _nothing_seen(table):
    table["visible"] = False


def _back_in_time(table):
    table.loc[table.index >= 20, "time_s"] -= 0.2


STREAM_DAMAGE = {
    "marker clock runs back": (MARKERS, _back_in_time, "clock"),
    "drive clock stands still": (DRIVES, lambda t: _set(5, "time_s", float(t["time_s"][4]))(t), "clock"),
    "NaN where visible": (MARKERS, _set(2, "x_m", float("nan")), "visible"),
    "all occluded": (MARKERS, _nothing_seen, "no marker is visible"),
    "a marker row is missing": (MARKERS, lambda t: t.drop(index=4), "one row per marker"),
    "a marker without an anchor": (MARKERS, lambda t: t.assign(marker=t["marker"].replace(5, 6)), "no anchor"),
    "markers in millimetres": (MARKERS, _scale("x_m", "y_m", "z_m"), "millimetres"),
    "clocks that do not overlap": (MARKERS, lambda t: t.assign(time_s=t["time_s"] + 100), "overlap"),
    "a column too many": (MARKERS, lambda t: t.assign(speed=1.0), "columns"),
    "a jump of the drive": (DRIVES, _set(7, "x_m", 0.4), "jumps"),
    "a spin of the drive": (
        DRIVES,
        lambda t: t.assign(
            qw=np.where(t.index == 7, 0.0, t["qw"]),
            qx=np.where(t.index == 7, 1.0, t["qx"]),
            qz=np.where(t.index == 7, 0.0, t["qz"]),
        ),
        "turns",
    ),
    "drives in millimetres": (DRIVES, _scale("x_m", "y_m", "z_m"), "millimetres"),
    "drive with NaN": (DRIVES, _set(3, "y_m", float("nan")), "finite"),
    "quaternion not unit": (DRIVES, _set(3, "qx", 0.5), "quaternion"),
    "open beyond 1": (DRIVES, _set(3, "open", 1.5), "open"),
    "no drive rows": (DRIVES, lambda t: t.iloc[:0], "no rows"),
    "anchor off the mesh": ("anchors.parquet", _set(1, "face", 2), "face 2 of 2"),
    "barycentrics off 1": ("anchors.parquet", _set(1, "b0", 0.4), "sum to 1"),
    "barycentrics outside": (
        "anchors.parquet",
        lambda t: t.assign(b0=[1.5, 0.2, 0], b1=[-0.5, 0.3, 0]),
        "outside its face",
    ),
    "two anchors of a marker": ("anchors.parquet", _set(1, "marker", 2), "two anchors"),
}


@pytest.mark.parametrize("damage", STREAM_DAMAGE)
def test_a_damaged_stream_is_refused_by_name(folder, damage):
    file, edit, words = STREAM_DAMAGE[damage]
    change(folder / file, edit)
    with pytest.raises(BadInput, match=words) as error:
        read_bundle(folder)
    assert Path(file).name in str(error.value)


def _hold(content):
    return content["recordings"][0]["holds"][0]


YAML_DAMAGE = {
    "unknown key": lambda c: c.update(colour="red"),
    "unknown key of a hold": lambda c: _hold(c).update(force_n=1),
    "wrong schema": lambda c: c.update(schema="sim1.recordings/2"),
    "prior missing": lambda c: c["garment"]["prior"].pop("poisson"),
    "negative stiffness": lambda c: c["garment"]["prior"]["stretch_n_m"].update(value=-4.0),
    "density in grams": lambda c: c["garment"]["prior"]["area_density_kg_m2"].update(value=200.0),
    "NaN in a prior": lambda c: c["garment"]["prior"]["stretch_n_m"].update(value=float("nan")),
    "unknown vertex": lambda c: _hold(c).update(vertices=[0, 99]),
    "unknown drive": lambda c: _hold(c).update(drive="third"),
    "hold outside the recording": lambda c: _hold(c).update(to_s=9.0),
    "hold that ends before it starts": lambda c: _hold(c).update(from_s=0.3, to_s=0.1),
    "places for another number of vertices": lambda c: _hold(c).update(places_m=[[0, 0, 0]]),
    "a vertex held twice": lambda c: c["recordings"][0]["holds"].append(dict(_hold(c))),
    "two recordings of one name": lambda c: c["recordings"][1].update(name="swing_a"),
    "a path as a name": lambda c: c["recordings"][1].update(name="../b"),
    "no recording": lambda c: c.update(recordings=[]),
    "no gravity": lambda c: c["environment"].update(gravity_m_s2=[0, 0, 0]),
}


@pytest.mark.parametrize("damage", YAML_DAMAGE)
def test_a_damaged_bundle_file_is_refused_by_name(folder, damage):
    change_yaml(folder, YAML_DAMAGE[damage])
    with pytest.raises(BadInput, match=r"bundle\.yaml"):
        read_bundle(folder)


@pytest.mark.parametrize("file", ["bundle.yaml", "garment.obj", "anchors.parquet", MARKERS, DRIVES])
def test_a_missing_or_cut_file_is_refused_by_name(folder, file):
    path = folder / file
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] + b"\xff\xfe\x00")
    with pytest.raises(BadInput, match=Path(file).name.replace(".", r"\.")):
        read_bundle(folder)
    path.unlink()
    with pytest.raises(BadInput, match=Path(file).name.replace(".", r"\.")):
        read_bundle(folder)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("f 1/1 2/2 3/3", "f 1/1 2/2 9/3"),
        ("f 1/1 2/2 3/3", "f 1 2 3 4"),
        ("v 0.3 0 0", "v 300 0 0"),
        ("vt 0.3 0", "vt 3 0"),
        ("v 0.3 0 0", "v nan 0 0"),
        ("v 0.3 0 0", "v x 0 0"),
    ],
)
def test_a_damaged_mesh_is_refused_by_name(folder, old, new):
    text = (folder / "garment.obj").read_text()
    assert old in text
    text = text.replace("vt 0.3", "vt 3") if new.startswith("vt") else text.replace(old, new, 1)
    (folder / "garment.obj").write_text(text)
    with pytest.raises(BadInput, match=r"garment\.obj"):
        read_bundle(folder)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    row=st.integers(0, SAMPLES - 1),
    column=st.sampled_from(["time_s", "x_m", "y_m", "z_m", "qw", "qz", "open"]),
    value=st.sampled_from([np.nan, np.inf, -np.inf, 1e6, -1e6]),
)
def test_no_single_absurd_value_of_a_drive_gets_through(folder, row, column, value):
    path = folder / DRIVES
    whole = path.read_bytes()
    change(path, _set(row, column, float(value)))
    try:
        with pytest.raises(BadInput, match=r"drives\.parquet|bundle\.yaml|markers\.parquet"):
            read_bundle(folder)
    finally:
        path.write_bytes(whole)


@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(shift=st.floats(-2, 2), hidden=st.sets(st.integers(0, 3 * FRAMES - 1), max_size=20))
def test_occlusion_and_place_survive_a_round_trip(folder, tmp_path, shift, hidden):
    ours = small_bundle()
    markers = (ours.recordings[0].markers_m + np.array([0, 0, shift])).reshape(-1, 3)
    markers[sorted(hidden)] = np.nan
    changed = replace(ours.recordings[0], markers_m=markers.reshape(FRAMES, 3, 3))
    write_bundle(tmp_path / "trip", replace(ours, recordings=(changed,)))
    back = read_bundle(tmp_path / "trip").recordings[0]
    np.testing.assert_allclose(back.markers_m, changed.markers_m, atol=1e-6)
