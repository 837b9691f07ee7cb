"""One small case from drawing to files: the bundle has the format's shape and the answers tell the truth of it."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import yaml
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from benchmarks.concealed import make as laboratory
from benchmarks.concealed.__main__ import app
from benchmarks.concealed.case import Case, Plan
from benchmarks.concealed.markers import camera_noise, cubic_weights, drop_outs
from benchmarks.concealed.motions import MOTIONS
from sim1.proof.answers import read_courses
from sim1.proof.unseen import motions_of, off_m


def two_plans(case: Case, setting) -> list[Plan]:
    """One recording and a held-out one, on the table: quickly brought to rest."""
    rng = np.random.default_rng(0)
    motions = [MOTIONS[name](setting.cloth, setting.columns, setting.rows, rng) for name in ("shuttle", "trail")]
    return [
        Plan(f"{motion.name}_a", motion.placed(0.3, np.array([0.1, 0.2, 0.0])), True, bool(number))
        for number, motion in enumerate(motions)
    ]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("case")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(laboratory, "plans", two_plans)
        found = laboratory.make(
            Case(("clock_offset",), "medium", 5, ("shuttle", "trail")),  # motions that were chosen: one cloth is tried
            folder / "bundle",
            folder / "answers.json",
            folder / "heldout",
        )
    return SimpleNamespace(
        folder=folder,
        found=found,
        answers=json.loads((folder / "answers.json").read_text()),
        arrays=np.load(folder / "answers.npz"),
        bundle=yaml.safe_load((folder / "bundle/bundle.yaml").read_text()),
        markers=pd.read_parquet(folder / "bundle/recordings/shuttle_a/markers.parquet"),
        drives=pd.read_parquet(folder / "bundle/recordings/shuttle_a/drives.parquet"),
        anchors=pd.read_parquet(folder / "bundle/anchors.parquet"),
    )


def read_mesh(path: Path) -> tuple[np.ndarray, np.ndarray]:
    lines = [line.split() for line in path.read_text().splitlines()]
    vertices = np.array([[float(value) for value in line[1:]] for line in lines if line[0] == "v"])
    faces = np.array([[int(part.split("/")[0]) - 1 for part in line[1:]] for line in lines if line[0] == "f"])
    return vertices, faces


def test_how_long_filming_took_is_told_and_is_no_part_of_the_answers(made):
    """Else a case that was committed to could never be filmed again."""
    assert made.found["made_in_s"] >= 0.0
    assert "made_in_s" not in made.answers


@pytest.mark.slow
def test_filmed_again_answers_and_films_are_the_same_to_the_byte(made, tmp_path, monkeypatch):
    """A case that was committed to can be filmed elsewhere: nothing in its files comes from the clock."""
    monkeypatch.setattr(laboratory, "plans", two_plans)
    laboratory.make(
        Case(("clock_offset",), "medium", 5, ("shuttle", "trail")),
        tmp_path / "bundle",
        tmp_path / "answers.json",
        tmp_path / "heldout",
    )
    files = [path.relative_to(tmp_path) for path in tmp_path.rglob("*") if path.is_file()]
    assert len(files) == 12
    for file in files:
        assert (tmp_path / file).read_bytes() == (made.folder / file).read_bytes(), file


def test_bundle_has_the_columns_of_the_format(made):
    assert made.bundle["schema"] == "sim1.recordings/1"
    assert list(made.markers) == ["time_s", "marker", "x_m", "y_m", "z_m", "visible"]
    assert list(made.drives) == ["time_s", "drive", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz", "open"]
    assert list(made.anchors) == ["marker", "face", "b0", "b1", "b2"]
    assert made.bundle["environment"]["table"]["height_m"] == 0.0
    assert set(made.bundle["garment"]["prior"]) == {
        "area_density_kg_m2",
        "thickness_m",
        "stretch_n_m",
        "poisson",
        "bending_n_m",
        "damping_s",
    }
    hidden = made.markers[~made.markers.visible]
    assert 0 < len(hidden) < 0.3 * len(made.markers)
    assert hidden[["x_m", "y_m", "z_m"]].isna().all().all()
    assert made.markers[made.markers.visible].notna().all().all()
    assert np.linalg.norm(made.drives[["qw", "qx", "qy", "qz"]], axis=1) == pytest.approx(1)
    assert made.drives.time_s.iloc[0] == 0
    assert made.drives.time_s.iloc[-1] == 4


def test_nothing_in_the_bundle_names_the_effect(made):
    assert not [path for path in (made.folder / "bundle").rglob("*") if "clock" in path.name]
    assert "clock" not in (made.folder / "bundle/bundle.yaml").read_text()


def test_anchors_and_holds_lie_where_the_resting_markers_and_drives_are(made):
    """From the bundle alone: the sheet is flat at rest, so drives and anchors foretell the first frames."""
    vertices, faces = read_mesh(made.folder / "bundle/garment.obj")
    anchors = made.anchors[["b0", "b1", "b2"]].to_numpy()
    assert anchors.sum(axis=1) == pytest.approx(1)
    assert anchors.min() > -1e-9
    material = (vertices[faces[made.anchors.face]] * anchors[:, :, None]).sum(axis=1)
    assert material[:, :2] == pytest.approx(np.array(made.answers["markers_uv_m"]), abs=1e-6)
    hold = made.bundle["recordings"][0]["holds"][0]
    first = made.drives.iloc[0]
    turn = Rotation.from_quat(first[["qx", "qy", "qz", "qw"]].to_numpy(float))
    held = turn.apply(hold["places_m"]) + first[["x_m", "y_m", "z_m"]].to_numpy(float)
    middle = held.mean(axis=0) - turn.apply(vertices[hold["vertices"]].mean(axis=0))
    foretold = turn.apply(material) + middle
    rest = made.markers[made.markers.time_s < 0.5].groupby("marker")[["x_m", "y_m", "z_m"]].median().to_numpy()
    assert rest == pytest.approx(foretold, abs=4 * made.answers["noise_rms_m"])
    assert held[:, 2] == pytest.approx(made.answers["baseline"]["thickness_m"] / 2, abs=1e-6)


def test_markers_are_the_truth_plus_the_noise_that_the_answers_tell(made):
    clean = made.arrays["shuttle_a/clean_m"]
    seen = made.markers[["x_m", "y_m", "z_m"]].to_numpy().reshape(clean.shape)
    visible = made.markers.visible.to_numpy().reshape(clean.shape[:2])
    off = (seen - clean)[visible]
    assert np.sqrt((off**2).mean()) == pytest.approx(made.answers["noise_rms_m"], rel=0.1)
    assert made.arrays["shuttle_a/stamps_s"] == pytest.approx(made.markers.time_s.to_numpy()[:: clean.shape[1]])


def test_the_effect_is_in_the_markers_and_its_size_in_the_answers(made):
    effect = made.answers["effects"][0]
    offset = effect["parameters"]["offset"]
    truth, baseline = made.arrays["shuttle_a/truth_m"], made.arrays["shuttle_a/baseline_m"]
    times = made.arrays["shuttle_a/truth_s"]
    marker = int(np.abs(baseline - baseline[0]).max(axis=(0, 2)).argmax())
    axis = int(np.abs(baseline[:, marker] - baseline[0, marker]).max(axis=0).argmax())
    foretold = np.interp(times - offset, times, baseline[:, marker, axis])
    assert truth[:, marker, axis] == pytest.approx(foretold, abs=2e-4)
    change = np.sqrt(((truth - baseline) ** 2).mean())
    assert made.answers["effect_rms_m"]["shuttle_a"] == pytest.approx(change, rel=0.05)
    assert 3.5 / 1.4 < effect["own_rms_m"] / made.answers["noise_rms_m"] < 3.5 * 1.4
    assert effect["own_rms_m"] < made.answers["effect_rms_m"]["largest"]
    assert np.abs(made.arrays["shuttle_a/missing_n_m2"]).max() == 0
    assert made.arrays["shuttle_a/report_shift_m"].max() > 1e-3


def test_the_sheet_is_at_rest_first_and_never_goes_through_itself(made):
    for recording in made.answers["recordings"]:
        assert recording["rest_speed_m_s"] < 1e-4
        assert recording["nearest_m"] > 0.02
    early = made.arrays["shuttle_a/baseline_m"][:30]
    assert np.abs(early - early[0]).max() < 1e-4


def test_held_out_bundle_keeps_half_a_second_of_markers_and_all_of_the_drives(made):
    folder = made.folder / "heldout/recordings/trail_a"
    assert pd.read_parquet(folder / "markers.parquet").time_s.max() <= 0.5
    assert pd.read_parquet(folder / "drives.parquet").time_s.max() == 4
    assert made.arrays["trail_a/truth_m"].shape[0] == 241


def test_the_proof_sets_predictions_against_the_held_out_motions_alone(made):
    """Its reader, on this laboratory's own files: answers tell how every motion went, those that were given too."""
    motions = motions_of(made.folder / "heldout")
    assert motions == ["trail_a"]
    assert "shuttle_a/truth_s" in made.arrays
    courses = read_courses(made.folder / "answers.npz", motions_of(made.folder / "bundle"))
    time_s, truth_m = courses["trail_a/truth_s"], courses["trail_a/truth_m"]
    places_m = (truth_m + 0.001).reshape(-1, 3)
    table = pd.DataFrame(places_m, columns=["x_m", "y_m", "z_m"]).assign(
        recording="trail_a",
        time_s=np.repeat(time_s, truth_m.shape[1]),
        marker=np.tile(np.arange(truth_m.shape[1]), len(time_s)),
    )
    assert off_m(table, courses, motions) == pytest.approx(0.001, rel=1e-4)  # truths are 32-bit


def test_the_camera_errs_as_asked_and_loses_markers_for_a_while():
    rng = np.random.default_rng(0)
    noise = camera_noise((400, 30, 3), 80.0, 0.001, rng)
    assert np.sqrt((noise**2).mean()) == pytest.approx(0.001, rel=0.05)
    assert (np.abs(noise) > 0.004).sum() > 5, "heavy tails"
    lagged = (noise[8:] * noise[:-8]).mean() / (noise**2).mean()
    assert lagged > 0.03, "what wanders is still there a tenth of a second later"
    visible = drop_outs(400, 30, rng)
    lost = np.diff(np.flatnonzero(np.diff(np.pad(~visible.T.ravel(), 1).astype(int))).reshape(-1, 2), axis=1)
    assert lost.min() >= 1
    assert lost.mean() > 3


def test_marker_weights_are_exact_on_cubics():
    from benchmarks.concealed.cloth import Grid

    grid = Grid(9, 7, 0.05, 0.04)
    uv = np.random.default_rng(0).uniform(0, 1, (20, 2)) * [0.4, 0.24]

    def surface(place):
        u, v = place.T
        return 1 + u**3 - 2 * u * v**2 + v**3

    assert cubic_weights(grid, uv) @ surface(grid.flat_uv_m) == pytest.approx(surface(uv), abs=1e-12)


def test_everything_follows_from_the_seed():
    first, second = (Case(("air_drag",), "medium", 3) for _ in range(2))
    assert first.setting().cloth == second.setting().cloth
    assert first.stream("a").random() == second.stream("a").random()
    assert first.stream("a").random() != first.stream("b").random()
    with pytest.raises(ValueError, match="no effect 'dragg': choose from air_drag"):
        Case(("dragg",), "medium", 1)
    with pytest.raises(ValueError, match="no strength"):
        Case((), "mild", 1)


def test_command_line_lists_effects_and_skips_what_is_there(tmp_path):
    listed = CliRunner().invoke(app, ["list"])
    assert listed.exit_code == 0
    assert "air_drag" in listed.output
    (tmp_path / "cases.yaml").write_text("- {effects: [none], seed: 1}\n")
    (tmp_path / "none_1").mkdir()
    (tmp_path / "none_1/answers.json").write_text("{}")
    done = CliRunner().invoke(app, ["many", "--cases", str(tmp_path / "cases.yaml"), "--out", str(tmp_path)])
    assert done.exit_code == 0
    assert done.output == ""
