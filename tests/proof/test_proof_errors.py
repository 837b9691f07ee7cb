"""How far off a coefficient is said to be: in units of what was concealed."""

import json
import math

import pytest

from sim1.proof.answers import Answers, read_answers
from sim1.proof.errors import effect_errors, relative_error
from sim1.proof.outcome import Number
from sim1.stage import BadInput


def number(found, true, unit="1"):
    return Number(value=found, low=0.0, high=10.0, unit=unit, true=true)


def test_a_small_component_is_measured_by_the_largest_of_its_kind():
    tilts = {"tilt_x": number(0.010, 0.011, "rad"), "tilt_y": number(0.0001, 0.0002, "rad")}
    assert effect_errors("gravity_tilt", tilts) == pytest.approx([0.001 / 0.011, 0.0001 / 0.011])


def test_what_is_1_where_nothing_is_there_is_measured_by_how_far_it_is_from_1():
    assert effect_errors("static_friction", {"ratio": number(1.3, 1.2)}) == pytest.approx([0.5])
    shrunk = {"scale_u": number(0.99, 0.98), "scale_v": number(1.0, 1.0)}
    assert effect_errors("shrinkage", shrunk) == pytest.approx([1 - math.log(0.99) / math.log(0.98), 0.0])
    twice = {"ratio_warp_weft": number(0.5, 2.0)}
    assert effect_errors("anisotropic_bending", twice) == pytest.approx([2.0])  # as far on the other side


def test_what_a_model_file_holds_in_place_of_a_coefficient_is_measured_as_that_coefficient():
    sides = {"mu_x": number(0.6, 0.5), "mu_y": number(0.4, 0.4)}
    assert effect_errors("anisotropic_friction", sides) == pytest.approx([math.log(1.5 / 1.25) / math.log(1.25)])
    assert effect_errors("grip_compliance", {"stiffness": number(400.0, 200.0, "N/m")}) == pytest.approx([0.5])
    assert effect_errors("anisotropic_friction", {"mu_x": number(0.6, 0.5)}) == pytest.approx([0.2])  # alone


def test_where_and_from_when_an_effect_acts_is_measured_by_itself():
    held = {
        "factor": number(2.0, 4.0),
        "centre_u": number(0.10, 0.12, "m"),
        "centre_v": number(0.20, 0.20, "m"),
        "radius": number(0.06, 0.05, "m"),
    }
    assert effect_errors("stiff_region", held) == pytest.approx([0.5, 0.1, 0.0, math.log(1.2)])


def test_without_a_truth_or_with_nothing_there_no_error_is_told():
    assert effect_errors("air_drag", {"c_normal": number(1.0, None)}) == []
    assert effect_errors("shrinkage", {"scale_u": number(1.1, 1.0)}) == []
    assert effect_errors("of_another_laboratory", {"c": number(1.0, 1.1)}) == pytest.approx([0.1 / 1.1])
    assert (relative_error(number(0.3, 0.4)), relative_error(number(0.3, None))) == ([pytest.approx(0.25)], [])


@pytest.mark.parametrize(("effect", "parameter"), [("anisotropic_friction", "mu_y"), ("grip_compliance", "stiffness")])
def test_a_truth_that_no_effect_can_have_is_refused_with_the_answers_before_anything_is_divided_by_it(
    tmp_path, effect, parameter
):
    told = {"mu_x": 0.5, "mu_y": 0.4} if parameter == "mu_y" else {"stiffness": 200.0}
    case = {"effects": [effect], "strength": "medium", "seed": 1}
    answers = {
        "case": case,
        "effects": [{"name": effect, "parameters": told | {parameter: 0.0}, "named_by_format": True}],
        "baseline": {},
        "places_given": True,
    }
    (tmp_path / "case_001.json").write_text(json.dumps(answers))
    with pytest.raises(
        BadInput, match=rf"case_001.json: {effect}: {parameter} is 0, must be above 0; film the case again"
    ):
        read_answers(tmp_path / "case_001.json")


def test_answers_say_how_strong_each_effect_came_out_where_the_laboratory_measured_it():
    effect = {"name": "wind", "parameters": {}, "named_by_format": True}
    asked = {"case": {"effects": ["wind"], "seed": 1}, "baseline": {}, "places_given": True, "target_rms_m": 0.002}
    measured = Answers.model_validate({**asked, "effects": [{**effect, "own_rms_m": 0.003}]})
    assert measured.reached == {"wind": pytest.approx(1.5)}
    assert Answers.model_validate({**asked, "effects": [effect]}).reached == {}
