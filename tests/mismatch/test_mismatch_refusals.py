"""What a diagnosis refuses before it simulates, `sim1 recordings check` does not call usable: in the same words, by the whole path."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import SIDE_M, empty_bundle
from typer.testing import CliRunner

from assets_defs.cli import app
from sim1.cloth.precise.material import marker_points, markers_on
from sim1.cloth.precise.mesh import square_sheet
from sim1.mismatch.engine import Engine
from sim1.recording.bundle import read_bundle, write_bundle
from sim1.stage import BadInput


def noisy(**options):
    return replace(empty_bundle(**options), noise_std_m=3e-4)


def moving(bundle):
    return replace(bundle, recordings=tuple(replace(one, starts="moving") for one in bundle.recordings))


def bent(bundle):
    bowl = bundle.mesh.vertices_m.copy()
    bowl[:, 2] = 2.0 * ((bowl[:, :2] - SIDE_M / 2) ** 2).sum(1)
    return replace(bundle, mesh=replace(bundle.mesh, vertices_m=bowl, material_m=None))


def seen_at_rest(bundle, markers):
    """The bundle with but some markers seen until the first recording moves."""
    first, *others = bundle.recordings
    hidden = first.markers_m.copy()
    hidden[np.ix_(first.time_s < 0.7, np.setdiff1d(np.arange(16), markers))] = np.nan
    return replace(bundle, recordings=(replace(first, markers_m=hidden), *others))


REFUSED = {
    "noise that nobody knows": (lambda: moving(empty_bundle()), "bundle.yaml: markers.noise_std_m is null"),
    "a grip that nobody measured": (
        lambda: moving(noisy(measured=False)),
        "bundle.yaml: recording swing_0: places_m of drive 'bar' is null",
    ),
    "a bent mesh without vt": (lambda: bent(noisy()), "garment.obj: no material coordinates (`vt`)"),
    "a mesh too small to bend": (lambda: noisy(count=2), "garment.obj: none of its 4 vertices lies inside"),
    "two markers at the start": (
        lambda: seen_at_rest(noisy(), [3, 8]),
        "recordings/swing_0/markers.parquet: at rest, until 0.540 s, 2 of 16 markers are seen",
    ),
    "markers on one line at the start": (
        lambda: seen_at_rest(noisy(), [0, 1, 2, 3]),
        "recordings/swing_0/markers.parquet: at rest, until 0.540 s, the 4 markers that are seen lie on one line",
    ),
}


def said_by(*words):
    answer = CliRunner().invoke(app, [str(word) for word in words])
    return answer.exit_code, " ".join(answer.output.split())


@pytest.mark.parametrize("wrong", REFUSED)
def test_what_a_diagnosis_refuses_is_not_called_usable(tmp_path, wrong):
    made, words = REFUSED[wrong]
    write_bundle(tmp_path / "b", made())
    (checked, wants), (diagnosed, stops) = (
        said_by("recordings", "check", tmp_path / "b"),
        said_by("diagnose", tmp_path / "b", "--out", tmp_path / "out"),
    )
    assert (checked, diagnosed) == (1, 2)
    for said in (wants, stops):
        assert f"{tmp_path / 'b'}/{words}" in said
    assert "usable" not in wants


def test_what_is_called_usable_is_made_ready_for_simulations(tmp_path):
    write_bundle(tmp_path / "b", noisy(measured=False))
    assert said_by("recordings", "check", tmp_path / "b")[0] == 0
    with Engine(read_bundle(tmp_path / "b"), processes=1) as engine:
        assert engine.observed(engine.names[0]).noise_m == pytest.approx(3e-4 / np.sqrt(2))


def test_a_mesh_is_called_by_the_name_that_it_has_in_the_bundle(tmp_path):
    write_bundle(tmp_path / "b", bent(noisy()))
    (tmp_path / "b/garment.obj").rename(tmp_path / "b/towel.obj")
    document = tmp_path / "b/bundle.yaml"
    document.write_text(document.read_text().replace("garment.obj", "towel.obj"))
    assert f"{tmp_path / 'b/towel.obj'}: no material coordinates" in said_by("recordings", "check", tmp_path / "b")[1]


def test_all_recordings_that_begin_with_too_few_markers_are_named(tmp_path):
    bundle = noisy()
    both = [seen_at_rest(replace(bundle, recordings=(one,)), [3]).recordings[0] for one in bundle.recordings[:2]]
    write_bundle(tmp_path / "b", replace(bundle, recordings=(*both, bundle.recordings[2])))
    wants = said_by("recordings", "check", tmp_path / "b")[1]
    assert "swing_0/markers.parquet: at rest" in wants
    assert "swing_1/markers.parquet: at rest" in wants


def test_a_marker_that_lies_off_the_sheet_is_named_with_its_file():
    whole = empty_bundle(motions=1)
    with pytest.raises(
        BadInput,
        match=r"^anchors\.parquet: marker 15 at \[0\.2\d*, 0\.2\d*\] m of the cloth lies off the sheet; correct",
    ):
        markers_on(whole, square_sheet(4, 0.7 * SIDE_M), marker_points(whole))
