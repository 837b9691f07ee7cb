"""The oracle of a proof starts where the answers say: the fabric, the effects, and a frame that is told about the origin."""

import json
from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle

from sim1.cloth.effects import EFFECTS
from sim1.proof.answers import read_answers
from sim1.proof.oracle import as_told, concealed

FRAME = {"tx": 0.004, "ty": -0.002, "tz": 0.003, "rx": 0.02, "ry": -0.01, "rz": 0.005}


def parameters_of(name: str) -> dict[str, float]:
    """Numbers that a model file could hold for an effect, no two alike: of coefficients from their own scale, else of about 1."""
    known = {c.name: c.value(0.3 + 0.1 * number) for number, c in enumerate(EFFECTS[name].coefficients)}
    return {key: known.get(key, 0.6 + 0.1 * number) for number, key in enumerate(EFFECTS[name].units())}


@pytest.mark.parametrize("name", EFFECTS)
def test_what_is_published_of_an_effect_leads_back_to_what_is_searched(name):
    model, z = as_told(empty_bundle(), {}, {})
    told = parameters_of(name)
    world = EFFECTS[name](**told).act(replace(model.world(z), frame_centre_m=(0.0, 0.0, 0.0)))
    values = EFFECTS[name].searched(told)
    assert set(values) == {c.name for c in EFFECTS[name].coefficients}
    assert EFFECTS[name].published(world, values) == pytest.approx(told)


@pytest.mark.parametrize("name", EFFECTS)
def test_the_oracle_starts_from_the_true_values_of_every_effect(name):
    told = parameters_of(name)
    friction = {"friction": (told["mu_x"] * told["mu_y"]) ** 0.5} if "mu_x" in told else {}
    model, z = as_told(empty_bundle(), {name: told}, {})
    world = replace(model.world(z), **friction)  # the fabric's: answers tell it with the baseline
    assert EFFECTS[name].published(world, model.values(0, z)) == pytest.approx(told)


def test_true_values_without_a_name_in_the_table_are_told_too(tmp_path):
    answers = tmp_path / "case_001.json"
    stream = {"vx": 0.3, "vy": -0.2, "vz": 0.05}
    wind = {"name": "wind", "parameters": stream, "extras": {"c_normal": 1.1, "c_tangential": 0.03}}
    lag = {"name": "actuator_lag", "parameters": {"time_constant": 0.02}}
    effects = [{**one, "named_by_format": True} for one in (wind, lag)]
    case = {"effects": ["wind", "actuator_lag"], "strength": "medium", "seed": 1}
    answers.write_text(json.dumps({"case": case, "effects": effects, "baseline": {}, "places_given": True}))
    model, z = as_told(empty_bundle(), concealed(read_answers(answers)), {})
    world = model.world(z)
    assert world.air_normal == pytest.approx(1.1)
    assert world.wind_m_s == pytest.approx(tuple(stream.values()))
    assert world.lag_s == pytest.approx(0.02)


def test_the_oracle_starts_from_what_was_concealed():
    model, z = as_told(empty_bundle(), {"frame_offset": FRAME, "clock_offset": {"offset": 0.05}}, {"poisson": 0.25})
    world = model.world(z)
    assert world.frame_shift_m == pytest.approx([FRAME[name] for name in ("tx", "ty", "tz")])
    assert world.frame_turn_rad == pytest.approx([FRAME[name] for name in ("rx", "ry", "rz")])
    assert world.clock_offset_s == pytest.approx(0.05)
    assert world.poisson == pytest.approx(0.25)


def test_what_answers_do_not_tell_starts_at_its_prior():
    model, z = as_told(empty_bundle(), {}, {})
    assert z == pytest.approx(np.zeros(model.count))
