"""From a stand-in lab with concealed parameters to a verdict, small sizes."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from sim1.cloth.physics import read_physics
from sim1.mismatch.stage import (
    CalibratedPhysicsConfig,
    MismatchReportConfig,
    calibrated_physics,
    check_calibrated_physics,
    check_mismatch_report,
    mismatch_report,
)
from sim1.mismatch.verdict import read_verdict
from sim1.recording.document import Priors
from sim1.recording.lab import draw_material
from sim1.recording.stage import RecordingsConfig, recordings
from sim1.stage import BadInput, random_stream

FABRIC = {
    "area_density_kg_m2": {"value": 0.2, "std": 0.01},
    "thickness_m": {"value": 0.001},
    "stretch_n_m": {"value": 400.0, "log_std": 0.7},
    "poisson": {"value": 0.3, "std": 0.1},
    "bending_n_m": {"value": 2.0e-5, "log_std": 0.7},
    "damping_s": {"value": 1.0e-3, "log_std": 1.0},
}
LAB = {
    "vertices_per_side": 6,
    "lab_vertices_per_side": 16,
    "lab_step_s": 1 / 120,
    "duration_s": 1.4,
    "markers_per_side": 4,
    "swings": ("slow", "mixed"),
}


def run(folder: Path, air: float, seed: int):
    """Recordings, calibration and report of a fabric, and the truth that was concealed."""
    garment = folder / "cloth.yaml"
    garment.write_text(
        yaml.safe_dump({"schema": "sim1.garment/1", "title": "Cloth", "units": "m", "openings": 1, "fabric": FABRIC})
    )
    places = {name: folder / name for name in ("recordings", "calibrated_physics", "mismatch_report")}
    for place in places.values():
        place.mkdir()
    inputs = {name: {"cloth": place} for name, place in places.items()}
    recordings(
        {"garment": {"cloth": garment}}, places["recordings"], RecordingsConfig(**LAB, air_probability=air, seed=seed)
    )
    calibrated_physics(inputs, places["calibrated_physics"], CalibratedPhysicsConfig())
    mismatch_report(inputs, places["mismatch_report"], MismatchReportConfig())
    truth = draw_material(Priors.model_validate(FABRIC), air, random_stream(seed, "cloth", "fabric"))
    return places, truth


@pytest.fixture(scope="module")
def airless(tmp_path_factory):
    return run(tmp_path_factory.mktemp("airless"), air=0.0, seed=6)


@pytest.fixture(scope="module")
def airy(tmp_path_factory):
    return run(tmp_path_factory.mktemp("airy"), air=1.0, seed=6)


def ratio(physics, name):
    return getattr(physics, name).value / physics.area_density_kg_m2.value


def test_with_nothing_missing_no_name_is_given(airless):
    verdict = read_verdict(airless[0]["mismatch_report"] / "verdict.json")
    assert verdict.verdict == "none"
    assert verdict.missing_physics == []
    assert verdict.mismatch.regions == []
    assert read_physics(airless[0]["calibrated_physics"] / "model.yaml").effects == ()


def test_concealed_parameters_lie_in_their_intervals(airless):
    places, truth = airless
    physics = read_physics(places["calibrated_physics"] / "model.yaml")
    for name in ("stretch_n_m", "bending_n_m", "damping_s", "area_density_kg_m2"):
        low, high = getattr(physics, name).ci95
        assert low <= getattr(truth, name) <= high, name


def test_the_fit_improves_on_the_prior_where_motion_tells(airless):
    places, truth = airless
    physics = read_physics(places["calibrated_physics"] / "model.yaml")
    true = truth.bending_n_m / truth.area_density_kg_m2
    prior = FABRIC["bending_n_m"]["value"] / FABRIC["area_density_kg_m2"]["value"]
    assert abs(np.log(ratio(physics, "bending_n_m") / true)) < 0.5 * abs(np.log(prior / true))


def test_air_that_was_concealed_is_named_with_its_coefficient(airy):
    places, truth = airy
    verdict = read_verdict(places["mismatch_report"] / "verdict.json")
    assert verdict.verdict == "named"
    assert [effect.name for effect in verdict.missing_physics] == ["air_drag"]
    drag = verdict.missing_physics[0].parameters["c_normal"]
    density = read_physics(places["calibrated_physics"] / "model.yaml").area_density_kg_m2.value
    assert drag.value / density == pytest.approx(truth.c_normal / truth.area_density_kg_m2, rel=0.15)
    assert drag.ci95[0] <= truth.c_normal * density / truth.area_density_kg_m2 <= drag.ci95[1]
    assert verdict.rmse_m.augmented.heldout < 0.7 * verdict.rmse_m.baseline.heldout


def test_the_model_names_the_air_and_the_baseline_does_not(airy):
    folder = airy[0]["calibrated_physics"]
    assert read_physics(folder / "baseline.yaml").effects == ()
    assert [effect["name"] for effect in read_physics(folder / "model.yaml").effects] == ["air_drag"]


def test_both_artifacts_pass_their_checks(airy):
    findings = check_calibrated_physics(airy[0]["calibrated_physics"])
    assert all(finding.passed for finding in findings if finding.blocking)
    assert {finding.name: finding.passed for finding in findings}["heldout_explained"]
    assert all(finding.passed for finding in check_mismatch_report(airy[0]["mismatch_report"]))


def test_the_page_stands_alone_and_says_that_the_lab_is_a_stand_in(airy):
    page = (airy[0]["mismatch_report"] / "report.html").read_text()
    assert "stand-in" in page
    assert "data:image/png;base64," in page
    assert "http" not in page


def test_a_damaged_verdict_is_blocked_and_an_unexplained_one_warned_of(airy, tmp_path):
    source = airy[0]["mismatch_report"]
    content = json.loads((source / "verdict.json").read_text())
    (tmp_path / "report.html").write_bytes((source / "report.html").read_bytes())
    unexplained = {**content, "verdict": "unknown", "missing_physics": []}
    (tmp_path / "verdict.json").write_text(json.dumps(unexplained))
    assert [(f.name, f.blocking) for f in check_mismatch_report(tmp_path) if not f.passed] == [
        ("mismatch_modelled", False)
    ]
    for damage in ({"verdict": "perhaps"}, {"verdict": "none"}, {"noise_std_m": -1.0}, {"extra": 1}):
        (tmp_path / "verdict.json").write_text(json.dumps({**content, **damage}))
        failed = [finding for finding in check_mismatch_report(tmp_path) if not finding.passed]
        assert [(f.name, f.blocking) for f in failed] == [("verdict_schema", True)]


def test_calibration_never_reads_what_is_concealed(airless, tmp_path):
    places, _ = airless
    (tmp_path / "bundle").symlink_to(places["recordings"] / "bundle")  # no origin.json here
    quick = CalibratedPhysicsConfig(iterations=1, passes=1, try_air_drag=False)
    (tmp_path / "out").mkdir()
    calibrated_physics({"recordings": {"cloth": tmp_path}}, tmp_path / "out", quick)
    assert read_physics(tmp_path / "out/model.yaml").effects == ()


def test_one_recording_alone_gives_a_message_and_no_model(airless, tmp_path):
    with pytest.raises(BadInput, match="at least two"):
        calibrated_physics(
            {"recordings": {"c": airless[0]["recordings"]}}, tmp_path, CalibratedPhysicsConfig(heldout=2)
        )
    assert not list(tmp_path.iterdir())
