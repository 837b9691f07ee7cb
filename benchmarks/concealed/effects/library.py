"""All effects by name: how strong they usually are, which motions show them, how they are drawn."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.concealed.effects.air import AddedMass, AirDrag, Wind
from benchmarks.concealed.effects.curl import BendingHysteresis, PlasticCrease, RestCurvature, ViscoelasticCreep
from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.effects.elastic import AnisotropicBending, AnisotropicStretch, Shrinkage, StrainStiffening
from benchmarks.concealed.effects.measurement import (
    CameraScale,
    ClockOffset,
    FrameOffset,
    GravityTilt,
    RollingShutter,
)
from benchmarks.concealed.effects.outside import Drying, FanJet, HiddenThread, Magnet, StaticCharge
from benchmarks.concealed.effects.patches import HeavyRegion, StiffRegion
from benchmarks.concealed.effects.robot import ActuatorLag, GripCompliance, GripperVibration, GripSlip
from benchmarks.concealed.effects.tabletop import (
    Adhesion,
    AnisotropicFriction,
    StaticFriction,
    ViscousFriction,
)
from benchmarks.concealed.motions.pulling import taut_load_n
from benchmarks.concealed.setting import Setting

Draw = Callable[[float, np.random.Generator, Setting], Effect]
"""From an amplitude (1 is a usual medium one), random choices and the setting. Choices must not depend on the amplitude."""

SWINGS = ("swing_out", "fast_swing", "twist", "bar_swing", "bar_roll", "bars_wave")
BENDS = ("bar_tilt", "bars_squeeze", "bars_wave", "bar_swing", "spread")
PULLS = ("centre_pull", "bars_shear", "bars_slant", "spread")
LOADS = (*PULLS, "bars_pull")
"""Of a grip: two clamps that pull a sheet evenly show how they hold it, and next to nothing of its stretch, which they dictate."""
HANGS = ("swing_out", "twist", "bar_swing", "bar_tilt", "bars_wave", "bars_squeeze", "heave")
UPRIGHT = ("swing_out", "twist", "bar_swing", "bar_tilt", "heave", "fast_swing")
TABLE = ("drag_raised", "lift_off", "peel", "lay_down", "shuttle", "inch")


@dataclass(frozen=True)
class Recipe:
    """How one effect is drawn."""

    draw: Draw
    shown_by: tuple[str, ...]
    """Motions that excite it."""
    amplitudes: tuple[float, float]
    """Smallest and largest amplitude that is physically plausible."""
    in_table: bool = True
    """Whether the format names it."""


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _point(rng: np.random.Generator, s: Setting, rim: float = 0.25) -> tuple[float, float]:
    """Material coordinates away from the rim."""
    return (
        round(float(rng.uniform(rim, 1 - rim) * s.cloth.size_u_m), 4),
        round(float(rng.uniform(max(rim, 0.35), 0.85) * s.cloth.size_v_m), 4),
    )


def _air_drag(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    return AirDrag({"c_normal": 1.4 * a, "c_tangential": 0.04 * a * rng.uniform(0.5, 1.5)})


def _wind(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    heading = s.yaw_rad + np.pi / 2 * _sign(rng) + rng.uniform(-0.5, 0.5)
    speed, rising = 0.55 * np.sqrt(a), rng.uniform(-0.15, 0.15)
    blow = {"vx": speed * np.cos(heading), "vy": speed * np.sin(heading), "vz": speed * rising}
    gusts = {"gust": float(rng.uniform(0.06, 0.12)), "waves_1": float(rng.integers(1, 4))}
    gusts |= {"waves_2": float(rng.integers(4, 8)), "profile": 1 / 7}
    return Wind({k: float(v) for k, v in blow.items()}, {"c_normal": 1.3, "c_tangential": 0.03, **gusts})


def _added_mass(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    return AddedMass({"mass": 0.08 * a})


def _anisotropic_stretch(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    return AnisotropicStretch({"ratio_warp_weft": float(np.exp(_sign(rng) * 0.9 * a))})


def _anisotropic_bending(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    return AnisotropicBending({"ratio_warp_weft": float(np.exp(_sign(rng) * 1.0 * a))})


def _strain_stiffening(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    return StrainStiffening({"growth": 20.0 * a}, {"straight": float(rng.uniform(3.5, 5.5))})


def _bending_hysteresis(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    return BendingHysteresis(
        {"moment": 5.0 * s.cloth.bending_n_m * a}, {"slip_curvature": float(rng.uniform(0.8, 2.0))}
    )


def _plastic_crease(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    retained = float(rng.uniform(0.4, 0.75))
    return PlasticCrease({"yield_curvature": 7.0 / np.sqrt(a), "retained": retained})


def _rest_curvature(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    angle = rng.uniform(0, 2 * np.pi)
    curls = {"kappa_u": float(4 * a * np.cos(angle)), "kappa_v": float(4 * a * np.sin(angle))}
    return RestCurvature(curls, {"fade": float(rng.uniform(0.15, 0.3))})


def _shrinkage(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    share = rng.uniform(0.3, 1.0, 2)
    scales = {"scale_u": float(1 - 0.015 * a * share[0]), "scale_v": float(1 - 0.015 * a * share[1])}
    return Shrinkage(scales, {"uneven": float(rng.uniform(0.15, 0.3)), "way": float(rng.uniform(0, 2 * np.pi))})


def _stiff_region(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    u, v = _point(rng, s)
    radius = round(float(rng.uniform(0.045, 0.075)), 4)
    return StiffRegion({"centre_u": u, "centre_v": v, "radius": radius, "factor": 1 + 8 * a})


def _heavy_region(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    u, v = _point(rng, s)
    mass = 0.15 * a * s.cloth.weight_n / 9.81
    return HeavyRegion({"centre_u": u, "centre_v": v, "mass": mass}, {"radius": float(rng.uniform(0.03, 0.05))})


def _static_friction(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    return StaticFriction({"ratio": 1 + 0.8 * a}, {"stribeck_speed": float(rng.uniform(0.015, 0.03))})


def _anisotropic_friction(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    factor = float(np.exp(_sign(rng) * 0.5 * a))
    return AnisotropicFriction({"mu_x": s.friction * factor, "mu_y": s.friction / factor})


def _adhesion(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    return Adhesion({"pressure": 1.0 * a}, {"reach": 0.0015})


def _grip_slip(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    resting = taut_load_n(s.cloth, s.rows)  # the largest of any motion: a recording promises half a second of rest
    return GripSlip({"threshold": float(rng.uniform(1.25, 1.7)) * resting, "rate": 0.01 * a})


def _grip_compliance(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    return GripCompliance({"stiffness": 200.0 / a}, {"jaw_mass": 0.02})


def _actuator_lag(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    return ActuatorLag({"time_constant": 0.025 * a})


def _clock_offset(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    return ClockOffset({"offset": _sign(rng) * 0.02 * a}, {"drift": _sign(rng) * float(rng.uniform(2e-5, 8e-5))})


def _frame_offset(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    shift, turn = rng.normal(size=3), rng.normal(size=3)
    shift, turn = 0.003 * a * shift / np.linalg.norm(shift), 0.006 * a * turn / np.linalg.norm(turn)
    keys = ("tx", "ty", "tz", "rx", "ry", "rz")
    return FrameOffset({key: float(value) for key, value in zip(keys, (*shift, *turn))})


def _gravity_tilt(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    angle = rng.uniform(0, 2 * np.pi)
    return GravityTilt({"tilt_x": float(0.02 * a * np.cos(angle)), "tilt_y": float(0.02 * a * np.sin(angle))})


def _fan_jet(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    side = _sign(rng)
    start = s.in_room(np.array([rng.uniform(-0.05, 0.05), 0.0, 0.8 - s.cloth.size_v_m * rng.uniform(0.4, 0.8)]))
    way = s.in_room(np.array([rng.uniform(-0.2, 0.2), side, 0.0])) - s.shift_m
    way /= np.linalg.norm(way)
    places = dict(zip(("x", "y", "z", "dx", "dy", "dz"), (float(value) for value in (*start, *way))))
    rates = {"rate_1": float(rng.uniform(0.8, 1.2)), "rate_2": float(rng.uniform(2.0, 3.0))}
    return FanJet({"speed": 1.2 * float(np.sqrt(a))}, {"width": 0.09, **places, **rates})


def _drying(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    u, v = _point(rng, s)
    mass = 0.25 * a * s.cloth.weight_n / 9.81
    return Drying({"mass": mass, "time": float(rng.uniform(1.0, 2.0))}, {"centre_u": u, "centre_v": v, "radius": 0.06})


def _hidden_thread(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    u, v = _point(rng, s)
    post = s.in_room(np.array([rng.uniform(-0.1, 0.1), 0.35 * _sign(rng), 0.8 - v]))
    return HiddenThread({"stiffness": 1.5 * a}, {"centre_u": u, "centre_v": v, **_xyz(post)})


def _magnet(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    u, v = _point(rng, s)
    place = s.in_room(np.array([u - s.cloth.size_u_m / 2, 0.09 * _sign(rng), 0.8 - v - 0.02]))
    return Magnet({"strength": 4e-6 * a}, {"core": 0.03, "centre_u": u, "centre_v": v, **_xyz(place)})


def _static_charge(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    rod = s.in_room(np.array([rng.uniform(-0.1, 0.1), 0.12 * _sign(rng), 0.0]))
    return StaticCharge({"strength": 0.006 * a * _sign(rng)}, {"core": 0.05, "x": float(rod[0]), "y": float(rod[1])})


def _viscoelastic_creep(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    return ViscoelasticCreep({"share": float(1 - np.exp(-0.5 * a)), "time": float(rng.uniform(0.4, 0.9))})


def _viscous_friction(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    return ViscousFriction({"fast_ratio": 1 + 1.5 * a, "fading_speed": float(rng.uniform(0.06, 0.12))})


def _gripper_vibration(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    way = rng.normal(size=3) * np.array([1.0, 1.0, 0.4])
    return GripperVibration(
        {"amplitude": 0.002 * a, "rate": float(rng.uniform(9, 17))}, _xyz(way / np.linalg.norm(way))
    )


def _rolling_shutter(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    return RollingShutter({"readout": 0.09 * a})


def _camera_scale(a: float, rng: np.random.Generator, s: Setting) -> Effect:
    centre = s.in_room(np.array([0.0, 0.0, 0.8]))
    return CameraScale({"scale": 1 + 0.015 * a * _sign(rng)}, _xyz(centre))


def _xyz(point: np.ndarray) -> dict[str, float]:
    return {"x": float(point[0]), "y": float(point[1]), "z": float(point[2])}


LIBRARY: dict[str, Recipe] = {
    "air_drag": Recipe(_air_drag, SWINGS, (0.02, 4.0)),
    "wind": Recipe(_wind, HANGS, (0.05, 6.0)),
    "added_mass": Recipe(_added_mass, SWINGS, (0.02, 3.0)),
    "anisotropic_stretch": Recipe(_anisotropic_stretch, PULLS, (0.05, 2.0)),
    "anisotropic_bending": Recipe(_anisotropic_bending, BENDS, (0.05, 2.0)),
    "strain_stiffening": Recipe(_strain_stiffening, PULLS, (0.1, 4.0)),
    "bending_hysteresis": Recipe(_bending_hysteresis, BENDS, (0.05, 4.0)),
    "plastic_crease": Recipe(_plastic_crease, BENDS, (0.1, 20.0)),
    "rest_curvature": Recipe(_rest_curvature, BENDS, (0.05, 3.0)),
    "shrinkage": Recipe(_shrinkage, (*HANGS, *PULLS), (0.05, 4.0)),
    "stiff_region": Recipe(_stiff_region, BENDS, (0.1, 3.0)),
    "heavy_region": Recipe(_heavy_region, HANGS, (0.05, 4.0)),
    "static_friction": Recipe(_static_friction, ("inch", "drag_raised", "lay_down", "shuttle"), (0.2, 2.5)),
    "anisotropic_friction": Recipe(_anisotropic_friction, ("trail", "shuttle", "drag_raised", "peel"), (0.1, 1.6)),
    "adhesion": Recipe(_adhesion, ("lift_off", "peel", "drag_raised", "lay_down"), (0.05, 6.0)),
    "grip_slip": Recipe(_grip_slip, LOADS, (0.002, 4.0)),
    "grip_compliance": Recipe(_grip_compliance, LOADS, (0.05, 8.0)),
    "actuator_lag": Recipe(_actuator_lag, (*SWINGS, "swing_in_plane", "heave", "bars_shear"), (0.1, 4.0)),
    "clock_offset": Recipe(_clock_offset, (*SWINGS, "swing_in_plane", "heave", "bars_shear"), (0.1, 5.0)),
    "frame_offset": Recipe(_frame_offset, (*HANGS, *PULLS), (0.05, 5.0)),
    "gravity_tilt": Recipe(_gravity_tilt, HANGS, (0.05, 4.0)),
    "fan_jet": Recipe(_fan_jet, UPRIGHT, (0.05, 6.0), in_table=False),
    "drying": Recipe(_drying, HANGS, (0.05, 4.0), in_table=False),
    "hidden_thread": Recipe(_hidden_thread, UPRIGHT, (0.02, 20.0), in_table=False),
    "magnet": Recipe(_magnet, UPRIGHT, (0.02, 10.0), in_table=False),
    "static_charge": Recipe(_static_charge, UPRIGHT, (0.02, 10.0), in_table=False),
    "viscoelastic_creep": Recipe(_viscoelastic_creep, BENDS, (0.1, 3.0), in_table=False),
    "viscous_friction": Recipe(_viscous_friction, TABLE, (0.1, 3.0), in_table=False),
    "gripper_vibration": Recipe(_gripper_vibration, SWINGS, (0.1, 4.0), in_table=False),
    "rolling_shutter": Recipe(_rolling_shutter, SWINGS, (0.1, 5.0), in_table=False),
    "camera_scale": Recipe(_camera_scale, (*HANGS, *PULLS), (0.1, 3.0), in_table=False),
}
