from dataclasses import fields

import numpy as np
import pytest
from avbd_sheets import G, Run, cloth, hold, square_grid
from scipy.spatial.transform import Rotation

from sim1.cloth.effects import EFFECTS, Effect, acted_effects, effects_of
from sim1.cloth.effects.air_drag import AirDrag
from sim1.cloth.effects.anisotropic_stretch import AnisotropicStretch
from sim1.cloth.precise.world import World
from sim1.stage import BadInput

DENSITY = 0.2
POINTS, FACES = square_grid(6, 6, 0.02)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_a_flat_sheet_falls_in_air_as_a_plate_with_that_drag_coefficient(integrator):
    drag = AirDrag(c_normal=10.0)
    run = Run(cloth(POINTS, FACES, density=DENSITY), 1 / 1000, effects=(drag,), integrator=integrator)
    terminal = np.sqrt(2 * DENSITY * G / (1.2 * drag.c_normal))
    fallen = -run.trace(300, lambda now: now.v[:, 2].mean())
    seconds = np.arange(301) / 1000
    assert fallen == pytest.approx(terminal * np.tanh(G * seconds / terminal), abs=0.01 * terminal)


SHEET = {"area_density_kg_m2": 0.2, "stretch_n_m": 400.0, "poisson": 0.3, "bending_n_m": 2e-5, "damping_s": 1e-3}


def test_air_drag_that_would_throw_an_explicit_step_back_only_brakes():
    run = Run(cloth(POINTS, FACES, density=DENSITY), 1 / 60, effects=(AirDrag(c_normal=500.0),))
    speeds = run.put(v=np.array([0.0, 0.0, -5.0])).trace(60, lambda now: now.v[:, 2].mean())
    assert (speeds < 0).all()
    assert speeds[-1] == pytest.approx(-np.sqrt(2 * DENSITY * G / (1.2 * 500.0)), rel=0.02)


def test_a_sheet_that_moves_in_its_plane_feels_the_skin_drag_alone():
    still_air = {"gravity": (0.0, 0.0, 0.0), "density": DENSITY}
    kept = Run(cloth(POINTS, FACES, **still_air), 1 / 240, effects=(AirDrag(c_normal=5.0),))
    braked = Run(cloth(POINTS, FACES, **still_air), 1 / 960, effects=(AirDrag(c_normal=0.0, c_tangential=5.0),))
    start = np.array([2.0, 0.0, 0.0])
    assert kept.put(v=start).step(60).v[:, 0] == pytest.approx(2.0, abs=1e-3)
    slowed = 2.0 / (1 + 0.5 * 1.2 * 5.0 * 2.0 * 0.25 / DENSITY)  # dv/dt = -rho c v^2 / (2 density)
    assert braked.put(v=start).step(240).v[:, 0].mean() == pytest.approx(slowed, rel=0.02)


def hanging_extension(effects: tuple, along: int, compression_share: float = 1.0) -> float:
    """Lengthening of a sheet (8 x 8 cm) that hangs by the edge across axis `along` of its rest shape."""
    points, faces = square_grid(9, 9, 0.01)
    gravity = [0.0, 0.0, 0.0]
    gravity[along] = -G
    model = cloth(points, faces, gravity=tuple(gravity), density=2.0, tri_ke=100.0, tri_ka=0.0)
    hold(model, points[:, along] > 0.0799)
    run = Run(
        model, 10.0, effects=effects, iterations=300, warm_acceleration_g=0.0, compression_share=compression_share
    )
    for _ in range(3):
        run.put(v=np.zeros(3)).step()
    return float(-run.x[points[:, along] < 1e-9, along].mean())


@pytest.mark.parametrize("share", [1.0, 0.02])
@pytest.mark.parametrize("ratio", [4.0, 0.25])
def test_warp_and_weft_stretch_in_the_ratio_of_their_stiffnesses(ratio, share):
    plain = hanging_extension((), 0, share)
    along_warp = hanging_extension((AnisotropicStretch(ratio_warp_weft=ratio),), 0, share)
    along_weft = hanging_extension((AnisotropicStretch(ratio_warp_weft=ratio),), 1, share)
    turned = hanging_extension((AnisotropicStretch(ratio_warp_weft=ratio, warp=(0.0, 1.0, 0.0)),), 1, share)
    assert along_weft / along_warp == pytest.approx(ratio, rel=0.03)
    assert np.sqrt(along_weft * along_warp) == pytest.approx(plain, rel=0.03)
    assert turned == pytest.approx(along_warp, rel=0.03)


def test_effects_of_a_model_file_are_read_by_name_and_the_unknown_is_refused_by_name():
    drag = {"name": "air_drag", "parameters": {"c_normal": {"value": 1.7, "ci95": [1.5, 1.9], "unit": "1"}}}
    assert effects_of((drag,)) == (AirDrag(c_normal=1.7),)
    with pytest.raises(BadInput, match="'gremlins' is not an effect"):
        effects_of(({"name": "gremlins", "parameters": {}},))
    with pytest.raises(BadInput, match=r"air_drag has unknown parameters \['c_normla'\]"):
        effects_of(({"name": "air_drag", "parameters": {"c_normla": {"value": 1.0}}},))
    with pytest.raises(BadInput, match=r"effects: air_drag: c_normal is -1\.0, must be finite and between 0 and inf"):
        effects_of(({"name": "air_drag", "parameters": {"c_normal": {"value": -1.0}}},))
    with pytest.raises(BadInput, match="c_normal"):
        effects_of(({"name": "air_drag", "parameters": {}},))


def parameters_of(effect: type[Effect]) -> dict[str, float]:
    """Every number of an effect, within its limits."""
    limits = {c.name: (c.low, c.high) for c in effect.coefficients} | effect.limits
    numbers = (f.name for f in fields(effect) if f.name != "warp")
    return {name: float(np.clip(1.0, *limits.get(name, (-1.0, 1.0)))) for name in numbers}


@pytest.mark.parametrize("name", EFFECTS)
def test_a_parameter_beyond_its_limits_or_no_number_is_refused_with_effect_name_value_and_limits(name):
    effect, good = EFFECTS[name], parameters_of(EFFECTS[name])
    effect(**good)
    limits = {c.name: (c.low, c.high) for c in effect.coefficients} | effect.limits
    for parameter in good:
        low, high = limits.get(parameter, (-np.inf, np.inf))
        for bad in (np.nan, np.inf, -np.inf, "1.0", None, low - 1e-3, high + 1e-3):
            with pytest.raises(ValueError, match=f"{name}: {parameter} is .*between {low:g} and {high:g}"):
                effect(**{**good, parameter: bad})


@pytest.mark.parametrize(
    ("name", "parameter"),
    [
        ("adhesion", "reach"),
        ("anisotropic_bending", "ratio_warp_weft"),
        ("anisotropic_stretch", "ratio_warp_weft"),
        ("bending_hysteresis", "slip_curvature"),
        ("grip_compliance", "stiffness"),
        ("shrinkage", "scale_v"),
        ("static_friction", "stribeck_speed"),
    ],
)
def test_what_is_divided_by_is_not_0(name, parameter):
    with pytest.raises(ValueError, match=f"{name}: {parameter} is 0"):
        EFFECTS[name](**{**parameters_of(EFFECTS[name]), parameter: 0})


@pytest.mark.parametrize("warp", [(0.0, 0.0, 0.0), (np.nan, 1.0, 0.0), (1.0, 0.0)])
def test_a_warp_that_is_no_direction_is_refused(warp):
    with pytest.raises(ValueError, match="anisotropic_stretch: warp is"):
        AnisotropicStretch(ratio_warp_weft=2.0, warp=warp)


def test_every_effect_says_how_it_shows_and_where_its_formula_comes_from():
    for name, effect in EFFECTS.items():
        assert effect.name == name
        assert len(effect.signature) > 30
        assert len(effect.source) > 10


def test_physics_that_the_solver_cannot_act_is_refused_and_a_clock_is_none_of_its_business():
    clock = {"name": "clock_offset", "parameters": {"offset": {"value": 0.02}}}
    drag = {"name": "air_drag", "parameters": {"c_normal": {"value": 1.7}}}
    assert acted_effects((clock, drag)) == (AirDrag(c_normal=1.7),)
    button = {"centre_u": {"value": 0.1}, "centre_v": {"value": 0.1}, "mass": {"value": 0.01}}
    with pytest.raises(BadInput, match=r"'heavy_region'.*identification simulator.*baseline\.yaml"):
        acted_effects(({"name": "heavy_region", "parameters": button},))


def test_a_turned_frame_is_searched_about_the_cloth_and_told_about_the_origin():
    """Turned about a far origin, markers would mostly be shifted, and a search would take both for one."""
    frame, centre = EFFECTS["frame_offset"], np.array([0.6, -0.2, 0.4])
    values = {"tx": 0.001, "ty": 0.0, "tz": -0.002, "rx": 0.03, "ry": -0.01, "rz": 0.02}
    world = frame.alter(World(**SHEET, frame_centre_m=tuple(centre)), values)
    turned = Rotation.from_rotvec(world.frame_turn_rad).apply(centre) + world.frame_shift_m
    assert turned - centre == pytest.approx([0.001, 0.0, -0.002])
    told = frame(**frame.published(world, values)).act(World(**SHEET, frame_centre_m=(9.0, 9.0, 9.0)))
    assert told.frame_shift_m == pytest.approx(world.frame_shift_m)
    assert told.frame_turn_rad == world.frame_turn_rad
