"""Where a diagnosis and a prediction write: tried before the work, told in one line, and never half a file."""

import errno
from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle
from typer.testing import CliRunner

from assets_defs.cli import app
from sim1.cloth.physics import read_physics
from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.destination import write_whole
from sim1.mismatch.findings import FILES, run_diagnosis
from sim1.mismatch.fit import Fit
from sim1.mismatch.search import baseline
from sim1.recording.bundle import write_bundle
from sim1.stage import BadInput


@pytest.fixture(scope="module")
def bundle(tmp_path_factory):
    folder = tmp_path_factory.mktemp("destination") / "bundle"
    write_bundle(folder, replace(empty_bundle(), noise_std_m=3e-4))
    return folder


@pytest.fixture(scope="module")
def base():
    """The baseline at its priors, as a calibration leaves it."""
    unknowns = baseline(empty_bundle())
    size = unknowns.count
    return Fit(
        unknowns=unknowns,
        z=np.zeros(size),
        names=("swing_0",),
        temper={"swing_0": 1.0},
        residuals={"swing_0": np.zeros(9)},
        slopes={"swing_0": np.zeros((9, size))},
        mesh_off={"swing_0": np.zeros(9)},
        stretch={"swing_0": np.zeros(9, int)},
        converged=True,
    )


def refuse(*args, **kwargs):
    raise AssertionError("it went to work before it tried where to write")


def said_by(*command):
    answer = CliRunner().invoke(app, [str(word) for word in command])
    assert answer.exit_code == 2, answer.output
    return " ".join(answer.output.split())


def test_a_place_that_cannot_be_written_to_is_told_before_the_search(bundle, tmp_path, monkeypatch):
    monkeypatch.setattr("sim1.mismatch.findings.diagnose", refuse)
    (tmp_path / "file").write_text("taken")
    for out in (tmp_path / "file", tmp_path / "file" / "below"):
        said = said_by("diagnose", bundle, "--out", out)
        assert "cannot be written to" in said
        assert "give another place for --out" in said


def test_a_prediction_that_cannot_be_written_is_told_before_anything_is_simulated(bundle, tmp_path, monkeypatch):
    monkeypatch.setattr("sim1.mismatch.predict.predict", refuse)
    monkeypatch.setattr("sim1.mismatch.predict.read_physics", lambda path: None)
    (tmp_path / "file").write_text("taken")
    assert "is a folder" in said_by("predict", bundle, "--model", "m.yaml", "--out", tmp_path)
    assert "cannot be written to" in said_by(
        "predict", bundle, "--model", "m.yaml", "--out", tmp_path / "file" / "p.parquet"
    )


def full(path, *args, **kwargs):
    raise OSError(errno.ENOSPC, "No space left on device", str(path))


def test_a_disk_that_is_full_in_the_end_is_told_in_one_line(bundle, base, tmp_path, monkeypatch):
    class Foretold:
        to_parquet = staticmethod(full)

    monkeypatch.setattr("sim1.mismatch.findings.diagnose", lambda given, *, calibrated, **how: calibrated(base))
    monkeypatch.setattr("sim1.mismatch.findings.write_physics", full)
    monkeypatch.setattr("sim1.mismatch.predict.predict", lambda *asked: Foretold)
    monkeypatch.setattr("sim1.mismatch.predict.read_physics", lambda path: None)
    out = tmp_path / "out"
    for name, said in (
        ("baseline.yaml", said_by("diagnose", bundle, "--out", out)),
        ("p.parquet", said_by("predict", bundle, "--model", "m.yaml", "--out", out / "p.parquet")),
    ):
        assert f"{name}: cannot be written (No space left on device); free some space" in said
        assert "Traceback" not in said


def test_a_full_disk_takes_no_earlier_diagnosis_away(bundle, base, tmp_path, monkeypatch):
    monkeypatch.setattr("sim1.mismatch.findings.diagnose", lambda given, *, calibrated, **how: calibrated(base))
    monkeypatch.setattr("sim1.mismatch.findings.write_physics", full)
    for name in FILES:
        (tmp_path / name).write_text("of an earlier diagnosis")
    with pytest.raises(BadInput, match=r"baseline\.yaml: cannot be written"):
        run_diagnosis(bundle, tmp_path, lambda share, what: None)
    whole = dict.fromkeys(FILES, "of an earlier diagnosis")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == whole


def test_what_ends_badly_after_the_calibration_leaves_its_baseline_and_no_verdict_of_an_earlier_bundle(
    bundle, base, tmp_path, monkeypatch
):
    def lost(given, *, calibrated, **kwargs):
        calibrated(base)
        raise NotConverged("recording swing_0: no next state at 0.700 s")

    monkeypatch.setattr("sim1.mismatch.findings.diagnose", lost)
    for name in FILES:
        (tmp_path / name).write_text("of an earlier diagnosis")
    (tmp_path / "notes.txt").write_text("of a person")
    with pytest.raises(NotConverged):
        run_diagnosis(bundle, tmp_path, lambda share, what: None)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["baseline.yaml", "notes.txt"]
    assert read_physics(tmp_path / "baseline.yaml").effects == ()


def test_what_ends_badly_before_leaves_an_earlier_diagnosis_whole(bundle, tmp_path, monkeypatch):
    def lost(given, **kwargs):
        raise NotConverged("recording swing_0: no rest was found")

    monkeypatch.setattr("sim1.mismatch.findings.diagnose", lost)
    for name in FILES:
        (tmp_path / name).write_text("of an earlier diagnosis")
    with pytest.raises(NotConverged):
        run_diagnosis(bundle, tmp_path, lambda share, what: None)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == dict.fromkeys(
        FILES, "of an earlier diagnosis"
    )


def test_half_a_file_is_none(tmp_path):
    def half(path):
        path.write_text("ha")
        raise OSError(errno.ENOSPC, "No space left on device")

    (tmp_path / "verdict.json").write_text("whole")
    with pytest.raises(BadInput, match=r"verdict\.json: cannot be written \(No space"):
        write_whole(tmp_path / "verdict.json", half)
    assert [path.name for path in tmp_path.iterdir()] == ["verdict.json"]
    assert (tmp_path / "verdict.json").read_text() == "whole"
