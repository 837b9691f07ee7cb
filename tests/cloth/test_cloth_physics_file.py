from dataclasses import replace

import pytest
import yaml

from sim1.cloth.cell_physics import cell_physics, effects_left_out
from sim1.cloth.effects import acted_effects
from sim1.cloth.effects.air_drag import AirDrag
from sim1.cloth.physics import (
    ClothPhysics,
    Friction,
    Property,
    membrane,
    nominal_from_priors,
    read_physics,
    write_physics,
)
from sim1.stage import BadInput

FABRIC = {
    "area_density_kg_m2": {"value": 0.30, "std": 0.01},
    "thickness_m": {"value": 0.002},
    "stretch_n_m": {"value": 400.0, "log_std": 0.7},
    "poisson": {"value": 0.3, "std": 0.1},
    "bending_n_m": {"value": 5.0e-5, "log_std": 0.7},
    "damping_s": {"value": 1.0e-3, "log_std": 1.0},
}


def test_a_model_file_reads_back_as_written(tmp_path):
    physics = ClothPhysics(
        **{name: Property(value=item["value"], ci95=(0.0, 500.0)) for name, item in FABRIC.items()},
        friction=Friction(table=Property(value=0.5, ci95=(0.4, 0.6))),
        effects=({"name": "added_mass", "parameters": {"mass": {"value": 0.1, "ci95": None, "unit": "kg/m^2"}}},),
        mesh={"length_u": 1.0004, "rim": 1.3},
        mesh_refined=1,
    )
    write_physics(tmp_path / "model.yaml", physics)
    assert read_physics(tmp_path / "model.yaml") == physics


def test_priors_give_values_without_intervals():
    physics = nominal_from_priors(FABRIC)
    assert physics.stretch_n_m == Property(value=400.0, ci95=None)
    assert physics.friction.robot.value == 1.5


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"schema": "sim1.model/2"}, "schema"),
        ({"mesh": {"rim": -1.0}}, "mesh.rim"),
        ({"mesh": {"height": 1.0}}, "height"),
        ({"mesh_refined": -1}, "mesh_refined"),
        ({"mesh_refined": True}, "mesh_refined"),
        ({"stretch_n_m": {"value": -1.0, "ci95": None}}, "stretch_n_m"),
        ({"stretch_n_m": {"value": "400", "ci95": None}}, "stretch_n_m"),
        ({"poisson": {"value": 1.5, "ci95": None}}, "poisson"),
        ({"bending_n_m": {"value": 1e-5}}, "bending_n_m"),
        ({"damping_s": {"value": float("nan"), "ci95": None}}, "damping_s"),
        ({"thickness_m": {"value": 0.002, "ci95": [0.003, 0.001]}}, "ci95"),
        ({"colour": 3}, "colour"),
        ({"friction": {"table": {"value": 0.4, "ci95": None}}}, "friction"),
    ],
)
def test_a_damaged_model_file_is_refused_by_name(tmp_path, change, complaint):
    path = tmp_path / "model.yaml"
    write_physics(path, nominal_from_priors(FABRIC))
    path.write_text(yaml.safe_dump({**yaml.safe_load(path.read_text()), **change}))
    with pytest.raises(BadInput, match=complaint) as error:
        read_physics(path)
    assert "model.yaml" in str(error.value)


def test_plane_stress_moduli_give_back_youngs_modulus_and_poisson_ratio():
    lame = membrane(nominal_from_priors(FABRIC))
    young = 4 * lame.mu_n_m * (lame.lambda_n_m + lame.mu_n_m) / (lame.lambda_n_m + 2 * lame.mu_n_m)
    assert young == pytest.approx(400.0)
    assert lame.lambda_n_m / (lame.lambda_n_m + 2 * lame.mu_n_m) == pytest.approx(0.3)


def test_the_cell_gets_the_same_fabric_with_what_it_acts_and_is_told_what_it_lacks():
    given = {"clock_offset": ("offset",), "air_drag": ("c_normal",), "heavy_region": ("centre_u", "centre_v", "mass")}
    entries = tuple({"name": name, "parameters": {key: {"value": 0.4} for key in keys}} for name, keys in given.items())
    physics = replace(nominal_from_priors(FABRIC), effects=entries)
    acted = cell_physics(physics)
    assert acted == replace(physics, effects=entries[1:2])
    assert effects_left_out(physics, acted) == ("heavy_region",)
    assert effects_left_out(physics, nominal_from_priors(FABRIC)) == ("air_drag", "heavy_region")
    assert acted_effects(acted.effects) == (AirDrag(c_normal=0.4),)
