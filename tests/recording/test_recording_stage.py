import json
from pathlib import Path

import numpy as np
import pytest
from test_recording_bundle import small_bundle

from sim1.cloth.physics import read_physics
from sim1.recording.bundle import read_bundle, write_bundle
from sim1.recording.reality import read_world
from sim1.recording.stage import RealityConfig, RecordingsConfig, check_reality, check_recordings, reality, recordings
from sim1.stage import BadInput

TINY = {
    "vertices_per_side": 4,
    "lab_vertices_per_side": 7,
    "lab_step_s": 0.01,
    "duration_s": 1.0,
    "markers_per_side": 2,
    "swings": ("fast", "mixed"),
}
GARMENT = """schema: sim1.garment/1
title: Cloth
units: m
openings: 1
fabric:
  area_density_kg_m2: {value: 0.2, std: 0.01}
  thickness_m: {value: 0.001}
  stretch_n_m: {value: 400.0, log_std: 0.7}
  poisson: {value: 0.3, std: 0.1}
  bending_n_m: {value: 2.0e-5, log_std: 0.7}
  damping_s: {value: 1.0e-3, log_std: 1.0}
"""


@pytest.fixture
def garment(tmp_path):
    path = tmp_path / "cloth.yaml"
    path.write_text(GARMENT)
    return {"garment": {"cloth": path}}


def made(inputs, out: Path, **config):
    """Recordings with these settings; `fabric` is the seed of the concealed fabric."""
    out.mkdir()
    (out / "reality").mkdir()
    reality(inputs, out / "reality", RealityConfig(seed=config.pop("fabric", 1)))
    (out / "artifact").mkdir()
    inputs = {**inputs, "reality": {"cloth": out / "reality"}}
    return recordings(inputs, out / "artifact", RecordingsConfig(**config))


def test_a_given_bundle_is_checked_and_copied(garment, tmp_path):
    write_bundle(tmp_path / "lab", small_bundle())
    facts = made({**garment, "recordings": {"cloth": tmp_path / "lab"}}, tmp_path / "out")
    assert facts["virtual"] is False
    assert len(read_bundle(tmp_path / "out/artifact/bundle").recordings) == 2
    assert json.loads((tmp_path / "out/artifact/origin.json").read_text())["virtual"] is False
    assert all(finding.passed for finding in check_recordings(tmp_path / "out/artifact"))


def test_a_damaged_bundle_stops_the_stage(garment, tmp_path):
    write_bundle(tmp_path / "lab", small_bundle())
    (tmp_path / "lab/anchors.parquet").unlink()
    with pytest.raises(BadInput, match=r"anchors\.parquet"):
        made({**garment, "recordings": {"cloth": tmp_path / "lab"}}, tmp_path / "out")


def test_without_a_bundle_a_stand_in_says_that_it_is_one_and_hides_its_truth(garment, tmp_path):
    facts = made(garment, tmp_path / "out", **TINY)
    origin = json.loads((tmp_path / "out/artifact/origin.json").read_text())
    assert facts["virtual"] is True
    assert "stand-in" in facts["origin"]
    assert list(origin["concealed"]) == ["sha256"]
    assert all(finding.passed for finding in check_recordings(tmp_path / "out/artifact"))


def test_the_stand_in_is_the_same_every_time_and_another_with_another_seed(garment, tmp_path):
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        made(garment, tmp_path / name, **TINY, fabric=seed)
    files = sorted(path.relative_to(tmp_path / "a") for path in (tmp_path / "a").rglob("*") if path.is_file())
    assert all((tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes() for file in files)
    one, other = (read_bundle(tmp_path / name / "artifact" / "bundle").recordings[0].markers_m for name in "ac")
    assert np.nanmax(np.abs(one - other)) > 1e-4


def test_the_check_fails_on_a_single_recording(garment, tmp_path):
    made(garment, tmp_path / "out", **{**TINY, "swings": ("fast",)})
    failed = {finding.name for finding in check_recordings(tmp_path / "out/artifact") if not finding.passed}
    assert failed == {"held_out_motion"}


def test_reality_lies_within_what_is_known_of_the_fabric_and_reads_back(garment, tmp_path):
    for seed in range(20):
        place = tmp_path / str(seed)
        place.mkdir()
        reality(garment, place, RealityConfig(seed=seed))
        world, physics = read_world(place), read_physics(place / "cell.yaml")
        assert abs(np.log(world.stretch_n_m / 400.0)) <= 1.5 * 0.7 + 1e-9
        assert physics.stretch_n_m.value == world.stretch_n_m
        assert abs(np.log(physics.friction.table.value / 0.4)) <= 2 * 0.15 + 1e-9
        assert bool(physics.effects) == bool(world.air_normal)
        assert all(finding.passed for finding in check_reality(place))


def test_a_damaged_reality_is_named(garment, tmp_path):
    reality(garment, tmp_path, RealityConfig())
    (tmp_path / "reality.json").write_text('{"schema": "sim1.reality/1", "virtual": true, "world": {"mass": 1}}')
    with pytest.raises(BadInput, match=r"reality\.json"):
        read_world(tmp_path)
    assert not check_reality(tmp_path)[0].passed
