"""From a stand-in lab with concealed parameters to a verdict, small sizes."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from sim1.cloth.physics import read_physics, write_physics
from sim1.mismatch.stage import (
    CalibratedPhysicsConfig,
    MismatchReportConfig,
    calibrated_physics,
    check_calibrated_physics,
    check_mismatch_report,
    mismatch_report,
)
from sim1.mismatch.verdict import read_verdict
from sim1.recording.reality import read_world
from sim1.recording.stage import RealityConfig, RecordingsConfig, reality, recordings
from sim1.stage import BadInput

FABRIC = {
    "area_density_kg_m2": {"value": 0.2, "std": 0.01},
    "thickness_m": {"value": 0.001},
    "stretch_n_m": {"value": 400.0, "log_std": 0.7},
    "poisson": {"value": 0.3, "std": 0.1},
    "bending_n_m": {"value": 2.0e-5, "log_std": 0.7},
    "damping_s": {"value": 1.0e-3, "log_std": 1.0},
}
AIRY = {"vertices_per_side": 6, "lab_vertices_per_side": 16, "lab_step_s": 1 / 120}
AIRLESS = {
    "vertices_per_side": 6,
    "lab_vertices_per_side": 16,
    "lab_step_s": 1 / 120,
    "duration_s": 1.2,
    "markers_per_side": 4,
    "swings": ("slow", "mixed"),
}


def run(folder: Path, air: float, seed: int, sizes: dict):
    """Recordings, diagnosis and report of a fabric, and the truth that was concealed."""
    garment = folder / "cloth.yaml"
    garment.write_text(
        yaml.safe_dump({"schema": "sim1.garment/1", "title": "Cloth", "units": "m", "openings": 1, "fabric": FABRIC})
    )
    places = {name: folder / name for name in ("reality", "recordings", "calibrated_physics", "mismatch_report")}
    for place in places.values():
        place.mkdir()
    source = {"garment": {"cloth": garment}}
    reality(source, places["reality"], RealityConfig(effects={"air_drag": air}, seed=seed))
    given = {**source, "reality": {"cloth": places["reality"]}}
    recordings(given, places["recordings"], RecordingsConfig(**sizes, seed=seed))
    bare = folder / "bundle_alone"  # a diagnosis never sees where the bundle came from
    bare.mkdir()
    (bare / "bundle").symlink_to(places["recordings"] / "bundle")
    calibrated_physics({"recordings": {"cloth": bare}}, places["calibrated_physics"], CalibratedPhysicsConfig())
    inputs = {name: {"cloth": place} for name, place in places.items()}
    mismatch_report(inputs, places["mismatch_report"], MismatchReportConfig())
    return places, read_world(places["reality"])


@pytest.fixture(scope="module")
def airless(tmp_path_factory):
    return run(tmp_path_factory.mktemp("airless"), 0.0, 6, AIRLESS)


@pytest.fixture(scope="module")
def airy(tmp_path_factory):
    return run(tmp_path_factory.mktemp("airy"), 1.0, 6, AIRY)


def failed(findings) -> list[tuple[str, bool]]:
    return [(finding.name, finding.blocking) for finding in findings if not finding.passed]


def test_with_nothing_missing_no_name_is_given(airless):
    places, truth = airless
    assert truth.air_normal == 0.0
    verdict = read_verdict(places["mismatch_report"] / "verdict.json")
    assert verdict.verdict == "none"
    assert verdict.missing_physics == []
    assert verdict.mismatch.regions == []
    assert read_physics(places["calibrated_physics"] / "model.yaml").effects == ()


def test_concealed_parameters_lie_in_their_intervals(airless):
    places, truth = airless
    physics = read_physics(places["calibrated_physics"] / "model.yaml")
    for name in ("stretch_n_m", "bending_n_m", "damping_s", "area_density_kg_m2"):
        low, high = getattr(physics, name).ci95
        assert low <= getattr(truth, name) <= high, name
        assert 0.0 < low < high < np.inf, name
    low, high = physics.bending_n_m.ci95
    # Recordings told more than the data sheet.
    assert np.log(high / low) < 0.75 * 2 * 1.96 * FABRIC["bending_n_m"]["log_std"]


def test_the_fit_improves_on_the_prior_where_motion_tells(airless):
    places, truth = airless
    physics = read_physics(places["calibrated_physics"] / "model.yaml")
    true = truth.bending_n_m / truth.area_density_kg_m2
    found = physics.bending_n_m.value / physics.area_density_kg_m2.value
    prior = FABRIC["bending_n_m"]["value"] / FABRIC["area_density_kg_m2"]["value"]
    assert abs(np.log(found / true)) < 0.5 * abs(np.log(prior / true))


def test_air_that_was_concealed_is_named_with_its_coefficient(airy):
    places, truth = airy
    verdict = read_verdict(places["mismatch_report"] / "verdict.json")
    assert verdict.verdict == "named"
    assert [effect.name for effect in verdict.missing_physics] == ["air_drag"]
    drag = verdict.missing_physics[0].parameters["c_normal"]
    density = read_physics(places["calibrated_physics"] / "model.yaml").area_density_kg_m2.value
    assert drag.value / density == pytest.approx(truth.air_normal / truth.area_density_kg_m2, rel=0.15)
    assert drag.ci95[0] <= truth.air_normal * density / truth.area_density_kg_m2 <= drag.ci95[1]
    assert verdict.rmse_m.augmented.heldout < 0.7 * verdict.rmse_m.baseline.heldout


def test_the_model_and_the_cell_have_the_air_and_the_baseline_has_not(airy):
    folder = airy[0]["calibrated_physics"]
    assert read_physics(folder / "baseline.yaml").effects == ()
    assert [effect["name"] for effect in read_physics(folder / "model.yaml").effects] == ["air_drag"]
    model = read_physics(folder / "model.yaml")
    assert set(model.mesh) == {"length_u", "length_v", "clamp", "rim"}
    assert read_physics(folder / "cell.yaml") == replace(
        model, mesh={}, mesh_refined=None
    )  # the cell's mesh is another


def test_both_artifacts_pass_their_checks(airy):
    assert failed(check_calibrated_physics(airy[0]["calibrated_physics"])) == []
    assert failed(check_mismatch_report(airy[0]["mismatch_report"])) == []


def test_an_effect_that_the_cell_cannot_act_is_warned_of_by_name_and_kept_out_of_its_file(airy, tmp_path):
    folder = tmp_path / "calibrated"
    shutil.copytree(airy[0]["calibrated_physics"], folder)
    model = read_physics(folder / "model.yaml")
    places = {name: {"value": 0.1, "ci95": [0.05, 0.15], "unit": "m"} for name in ("centre_u", "centre_v")}
    button = {
        "name": "heavy_region",
        "parameters": {**places, "mass": {"value": 0.01, "ci95": [0.005, 0.02], "unit": "kg"}},
    }
    write_physics(folder / "model.yaml", replace(model, effects=(*model.effects, button)))
    findings = check_calibrated_physics(folder)
    assert failed(findings) == [("cell_acts_effects", False)]
    assert "heavy_region" in findings[-1].detail
    write_physics(folder / "cell.yaml", replace(model, effects=(*model.effects, button)))
    assert ("model_reads", True) in failed(check_calibrated_physics(folder))


def test_the_page_stands_alone_and_says_that_the_lab_is_a_stand_in(airy):
    page = (airy[0]["mismatch_report"] / "report.html").read_text()
    assert "stand-in" in page
    assert "data:image/png;base64," in page
    assert "http" not in page


def test_a_damaged_verdict_is_blocked_and_an_unexplained_one_warned_of(airy, tmp_path):
    source = airy[0]["mismatch_report"]
    content = json.loads((source / "verdict.json").read_text())
    shutil.copy(source / "report.html", tmp_path)
    unexplained = {**content, "verdict": "unknown", "missing_physics": []}
    (tmp_path / "verdict.json").write_text(json.dumps(unexplained))
    assert failed(check_mismatch_report(tmp_path)) == [("mismatch_modelled", False)]
    for damage in ({"verdict": "perhaps"}, {"verdict": "none"}, {"noise_std_m": -1.0}, {"extra": 1}):
        (tmp_path / "verdict.json").write_text(json.dumps({**content, **damage}))
        assert failed(check_mismatch_report(tmp_path)) == [("verdict_schema", True)]


@pytest.mark.parametrize(
    ("file", "content"),
    [
        ("summary.json", "{}"),
        ("verdict.json", "{"),
        ("forces.png", None),
        ("../recordings/origin.json", '{"virtual": 1}'),
    ],
)
def test_a_report_of_a_damaged_artifact_names_the_file(airy, tmp_path, file, content):
    inputs = {}
    for name in ("recordings", "calibrated_physics"):
        shutil.copytree(airy[0][name], tmp_path / name)
        inputs[name] = {"cloth": tmp_path / name}
    damaged = tmp_path / "calibrated_physics" / file
    damaged.unlink() if content is None else damaged.write_text(content)
    (tmp_path / "out").mkdir()
    with pytest.raises(BadInput, match=Path(file).name.replace(".", r"\.")):
        mismatch_report(inputs, tmp_path / "out", MismatchReportConfig())


def test_one_recording_alone_gives_a_message_and_no_model(airless, tmp_path):
    shutil.copytree(airless[0]["recordings"], tmp_path / "recordings")
    path = tmp_path / "recordings" / "bundle" / "bundle.yaml"
    content = yaml.safe_load(path.read_text())
    shutil.rmtree(path.parent / "recordings" / content["recordings"].pop()["name"])
    path.write_text(yaml.safe_dump(content))
    (tmp_path / "out").mkdir()
    with pytest.raises(BadInput, match="2 or more"):
        calibrated_physics({"recordings": {"c": tmp_path / "recordings"}}, tmp_path / "out", CalibratedPhysicsConfig())
    assert not list((tmp_path / "out").iterdir())
