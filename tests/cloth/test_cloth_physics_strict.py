"""A model file that a person wrote is read strictly: what is wrong is told with file, place, value and remedy."""

from copy import deepcopy
from dataclasses import fields
from pathlib import Path

import pytest
import yaml

from sim1.cloth.effects import EFFECTS, effects_of
from sim1.cloth.effects.anisotropic_stretch import AnisotropicStretch
from sim1.cloth.physics import physics_record, read_physics
from sim1.stage import BadInput

CAMPAIGNS = Path(__file__).parents[2] / "docs" / "campaign"
GOOD = {
    "schema": "sim1.model/1",
    "area_density_kg_m2": {"value": 0.3, "ci95": [0.29, 0.31]},
    "thickness_m": {"value": 0.002, "ci95": None},
    "stretch_n_m": {"value": 400.0, "ci95": None},
    "poisson": {"value": 0.3, "ci95": None},
    "bending_n_m": {"value": 5e-5, "ci95": None},
    "damping_s": {"value": 1e-3, "ci95": None},
    "friction": {name: {"value": 0.4, "ci95": None} for name in ("table", "robot", "self")},
    "effects": [
        {
            "name": "grip_slip",
            "parameters": {
                "threshold": {"value": 0.7, "ci95": [0.5, 0.8], "unit": "N"},
                "rate": {"value": 0.01, "ci95": None, "unit": "m/(N s)"},
            },
        }
    ],
    "grips": [
        {"drive": "bar", "vertices": [3, 4], "places_m": [[0.0, 0.0, 0.0], [0.03, 0.0, 0]], "recording": "swing"}
    ],
    "mesh": {"rim": 1.2},
    "mesh_refined": 1,
}


def changed(place, value):
    """The good file with another value at a path of keys and numbers."""
    content = deepcopy(GOOD)
    inner = content
    for step in place[:-1]:
        inner = inner[step]
    inner[place[-1]] = value
    return content


def refusal(tmp_path, content):
    path = tmp_path / "model.yaml"
    path.write_bytes(content if isinstance(content, bytes) else yaml.safe_dump(content).encode())
    with pytest.raises(BadInput) as error:
        read_physics(path)
    said = str(error.value)
    assert said.startswith(f"{path}: ")
    return said.removeprefix(f"{path}: ")


def test_the_good_file_reads_back_as_it_is(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump(GOOD))
    assert physics_record(read_physics(path)) == GOOD


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"\xff\xfe", "not readable as YAML ('utf-8' codec can't decode"),
        (
            yaml.safe_dump(GOOD).encode() + b"poisson: {value: 0.1, ci95: null}\n",
            "the key 'poisson' occurs twice line ",
        ),
        (b"when: 2020-13-45\n", "not readable as YAML (month must be in 1..12); correct the file"),
        (b"- 1\n", "schema is [1], expected 'sim1.model/1'; write it as"),
    ],
)
def test_what_is_no_model_file_at_all_is_refused(tmp_path, content, said):
    assert said in refusal(tmp_path, content)


@pytest.mark.parametrize(
    ("place", "value", "said"),
    [
        (("grips", 0, "vertices"), 3, "grips.0.vertices is 3: input should be a valid list"),
        (("grips", 0, "vertices"), [3, 3], "grips.0 is {"),
        (("grips", 0, "places_m", 0, 2), float("nan"), "grips.0.places_m.0.2 is nan: input should be a finite number"),
        (("grips", 0, "places_m", 0, 2), "0.1", "grips.0.places_m.0.2 is '0.1': input should be a valid number"),
        (("grips", 0, "places_m"), [[0.0, 0.0, 0.0]], "1 places_m for 2 vertices"),
        (("grips",), GOOD["grips"] * 2, "grips holds drive 'bar' with vertices [3, 4] in swing twice"),
        (("effects",), "air_drag", "effects is 'air_drag': input should be a valid list"),
        (("effects",), ["air_drag"], "effects.0 is 'air_drag', not keys and values"),
        (("effects", 0, "parameters", "rate", "value"), "0.01", "effects.0.parameters.rate.value.number is '0.01'"),
        (("effects", 0, "parameters", "rate"), {"value": 0.01, "ci95": None}, "key 'effects.0.parameters.rate.unit'"),
        (("mesh_refined",), True, "mesh_refined is True"),
    ],
)  # fmt: skip
def test_a_value_of_another_kind_is_refused_with_its_place_and_a_remedy(tmp_path, place, value, said):
    told = refusal(tmp_path, changed(place, value))
    assert said in told
    assert told.endswith("; write it as docs/artifacts.md shows, or make it again")


@pytest.mark.parametrize(
    ("place", "value", "said"),
    [
        (("name",), "gremlins", "'gremlins' is not an effect that the simulation knows; known: ['actuator_lag'"),
        (("parameters", "threshold", "unit"), "kN", "grip_slip: threshold is 0.7 kN, expected in N; give value and ci95"),
        (("parameters", "threshold", "value"), [1.0, 0.0, 0.0], "threshold is [1.0, 0.0, 0.0], expected one number in N"),
        (("parameters", "rate", "value"), -1.0, "grip_slip: rate is -1.0, must be finite and between 0 and inf"),
        (("parameters",), {}, "grip_slip lacks the parameters ['rate', 'threshold']"),
        (("parameters", "grit"), {"value": 1, "ci95": None, "unit": "1"}, "grip_slip has unknown parameters ['grit']"),
    ],
)  # fmt: skip
def test_an_effect_that_cannot_be_meant_is_refused_where_it_is_read(tmp_path, place, value, said):
    told = refusal(tmp_path, changed(("effects", 0, *place), value))
    assert told.startswith("effects: ")
    assert said in told


def test_an_effect_that_is_named_twice_is_refused(tmp_path):
    assert "grip_slip more than once" in refusal(tmp_path, changed(("effects",), GOOD["effects"] * 2))


def test_a_direction_is_three_numbers_and_nothing_else_is():
    ratio = {"value": 2.0, "ci95": None, "unit": "1"}

    def stretch(warp):
        parameters = {"ratio_warp_weft": ratio, "warp": {"value": warp, "ci95": None, "unit": "1"}}
        return effects_of(({"name": "anisotropic_stretch", "parameters": parameters},))

    assert stretch((0.0, 1.0, 0.0)) == (AnisotropicStretch(ratio_warp_weft=2.0, warp=(0.0, 1.0, 0.0)),)
    with pytest.raises(BadInput, match=r"^effects: anisotropic_stretch: warp is 1\.0, expected three numbers"):
        stretch(1.0)


@pytest.mark.parametrize("name", EFFECTS)
def test_every_parameter_of_an_effect_has_a_unit(name):
    effect = EFFECTS[name]
    assert set(effect.units() | effect.fixed) == {field.name for field in fields(effect)}


def stored():
    """Some of the model files of each campaign that has any."""
    for campaign in sorted(CAMPAIGNS.iterdir()):
        files = sorted((campaign / "found").glob("*/*.yaml"))
        yield from files[:: max(1, len(files) // 6)]


def test_stored_models_of_the_campaigns_are_read_as_they_were_written():
    files = list(stored())
    assert len({path.parts[-4] for path in files}) >= 2
    for path in files:
        assert physics_record(read_physics(path)) == yaml.safe_load(path.read_text())
