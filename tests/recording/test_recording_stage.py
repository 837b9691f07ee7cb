import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from swinging import board_bundle, swing
from test_recording_bundle import small_bundle

from sim1.cloth.effects import EFFECTS, acted_effects, acts, effects_of
from sim1.cloth.physics import PRIOR_FRICTION, read_physics
from sim1.recording.bundle import read_bundle, write_bundle
from sim1.recording.concealed import RANGES
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


def test_recordings_in_which_a_drive_only_turns_move(tmp_path):
    turned, still = swing("turned", shift_m=0.0, turn_rad=0.2), swing("still", shift_m=0.0)
    for name, other, passes in (("a", swing("b"), True), ("b", still, False)):
        write_bundle(tmp_path / name / "bundle", board_bundle(turned, other))
        found = {finding.name: finding for finding in check_recordings(tmp_path / name)}
        assert found["drives_move"].passed is passes
    assert found["drives_move"].detail.startswith("in ['still'] no drive moves")


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


def test_the_concealed_fabric_lies_within_what_is_known_of_it_and_reads_back(garment, tmp_path):
    for seed in range(20):
        place = tmp_path / str(seed)
        place.mkdir()
        reality(garment, place, RealityConfig(seed=seed))
        world, physics = read_world(place), read_physics(place / "cell.yaml")
        assert abs(np.log(world.stretch_n_m / 400.0)) <= 1.5 * 0.7 + 1e-9
        assert physics.stretch_n_m.value == world.stretch_n_m
        assert all(finding.passed for finding in check_reality(place))


def test_friction_in_reality_is_none_that_a_simulation_assumes(garment, tmp_path):
    for seed in range(20):
        place = tmp_path / str(seed)
        place.mkdir()
        reality(garment, place, RealityConfig(seed=seed))
        friction = read_physics(place / "cell.yaml").friction
        for name, assumed in PRIOR_FRICTION.items():
            assert 0.15 - 1e-9 <= abs(np.log(getattr(friction, name).value / assumed)) <= 0.4 + 1e-9


def test_each_effect_is_concealed_as_often_as_asked_and_acts_in_the_lab_as_in_the_cell(garment, tmp_path):
    chances = {"air_drag": 0.5, "anisotropic_bending": 0.5, "static_friction": 1.0}
    counts = dict.fromkeys(RANGES, 0)
    for seed in range(60):
        place = tmp_path / str(seed)
        place.mkdir()
        reality(garment, place, RealityConfig(seed=seed, effects=chances))
        world, physics = read_world(place), read_physics(place / "cell.yaml")
        found = {effect.name: effect for effect in effects_of(physics.effects)}
        for name in found:
            counts[name] += 1
        assert world.air_normal == (found["air_drag"].c_normal if "air_drag" in found else 0.0)
        bending = found["anisotropic_bending"].ratio_warp_weft if "anisotropic_bending" in found else 1.0
        assert world.bending_ratio == pytest.approx(bending)
        assert world.stiction == 1.0  # nothing lies on a table there
        assert found["static_friction"].ratio >= 1.3
    assert counts["static_friction"] == 60
    assert 18 <= counts["air_drag"] <= 42
    assert 18 <= counts["anisotropic_bending"] <= 42
    assert counts["anisotropic_stretch"] == counts["bending_hysteresis"] == counts["anisotropic_friction"] == 0


def test_every_effect_that_may_be_concealed_is_one_that_the_cell_acts(garment, tmp_path):
    assert all(acts(EFFECTS[name]) for name in RANGES)
    reality(garment, tmp_path, RealityConfig(effects=dict.fromkeys(RANGES, 1.0)))
    physics = read_physics(tmp_path / "cell.yaml")
    assert [effect.name for effect in acted_effects(physics.effects)] == list(RANGES)
    uneven = next(one for one in effects_of(physics.effects) if one.name == "anisotropic_friction")
    assert np.sqrt(uneven.mu_x * uneven.mu_y) == pytest.approx(physics.friction.table.value)


def test_an_effect_that_cannot_be_concealed_is_named(garment, tmp_path):
    for effects, told in (({"wind": 0.5}, "wind"), ({"air_drag": 1.5}, "between 0 and 1")):
        with pytest.raises(BadInput, match=told):
            reality(garment, tmp_path, RealityConfig(effects=effects))


def test_no_stage_that_makes_training_data_needs_reality_but_by_its_recordings():
    """Concealment is the graph's: what reaches the dataset goes through `recordings` alone."""
    stages = yaml.safe_load((Path(__file__).parents[2] / "pipeline" / "stages.yaml").read_text())["stages"]
    needs = {stage["name"]: set(stage.get("needs", ())) for stage in stages}
    reached, seen = {"dataset"}, set()
    while reached:
        name = reached.pop()
        seen.add(name)
        reached |= needs[name] - seen - ({"reality"} if name == "recordings" else set())
    assert "recordings" in seen
    assert "reality" not in seen


def test_a_damaged_reality_is_named(garment, tmp_path):
    reality(garment, tmp_path, RealityConfig())
    (tmp_path / "reality.json").write_text(
        '{"schema": "sim1.reality/2", "virtual": true, "fabric": {"mass": 1}, "effects": []}'
    )
    with pytest.raises(BadInput, match=r"reality\.json"):
        read_world(tmp_path)
    assert not check_reality(tmp_path)[0].passed
