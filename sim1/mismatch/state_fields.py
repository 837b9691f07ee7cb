"""The simplest force that each state of the sheet would make, up to factors: what a located force is set against.

Two kinds. A force may follow a state: fields that point as it would. Or a push in the room, or whatever else it follows, is stronger where a
state is larger: times the state's rank among all markers and steps (-1 to 1; a crease is no thousand times a fold).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sim1.mismatch.missing_force import Forces

SLOW_M_S = 0.01  # slower than this, the sign of a velocity is not known
TOUCHES_M = 1e-3  # above where cloth rests on the table
AXES = np.eye(3)
TABLE = "the table"

type Place = np.ndarray
"""Whether each marker is of the region that carries half of the force, (M,)."""


def _across(one: Forces, vector: np.ndarray) -> np.ndarray:
    """Part (T, M, 3) of a vector along the sheet's normal."""
    return (vector * one.states.normal).sum(-1, keepdims=True) * one.states.normal


def _along(one: Forces, vector: np.ndarray) -> np.ndarray:
    return vector - _across(one, vector)


def _power(velocity: np.ndarray, power: int) -> np.ndarray:
    speed = np.linalg.norm(velocity, axis=-1, keepdims=True)
    return velocity * np.hypot(speed, SLOW_M_S) ** (power - 1)


def fixed(one: Forces, factor: np.ndarray) -> list[np.ndarray]:
    """A push along each axis of the room, times a factor that may differ by step and marker."""
    size = np.broadcast_to(factor, one.force_n.shape[:2])[..., None]
    return [size * axis for axis in AXES]


def _touches(one: Forces) -> np.ndarray:
    assert one.table_z_m is not None  # asked only where there is a table
    return one.path_m[..., 2] < one.table_z_m + TOUCHES_M


def _acceleration(one: Forces) -> np.ndarray:
    return np.gradient(one.velocity_m_s, one.time_s, axis=0)


def _even(one: Forces) -> list[np.ndarray]:
    square = (one.velocity_m_s**2).sum(-1)
    return [*fixed(one, square), square[..., None] * one.states.normal]


@dataclass(frozen=True, kw_only=True)
class Law:
    """One way in which a force may follow a state."""

    state: str
    words: str  # what such a force does; {brakes} and {resists}: by the sign of its factor
    fields: Callable[[Forces], list[np.ndarray]]  # (T, M, 3) each
    vaguely: str = ""  # the same where this way is not told from the state's others
    reverses: bool = False  # with the motion: odd in the velocity


GROWS = {0: "by as much at any speed", 1: "in proportion to the speed", 2: "with the square of the speed"}


def _speed_laws(state: str, where: str, part: Callable[[Forces, np.ndarray], np.ndarray]) -> list[Law]:
    return [
        Law(
            state=state,
            words=f"{{brakes}} {GROWS[power]} {where}",
            vaguely=f"{{brakes}} with the speed {where}, to a power that is open",
            fields=lambda one, power=power: [_power(part(one, one.velocity_m_s), power)],
            reverses=True,
        )
        for power in GROWS
    ]


ROOM = Law(
    state="a direction in the room",
    words="pushes the same way in the room",
    fields=lambda one: fixed(one, np.ones(())),
)
LAWS = (
    ROOM,
    Law(
        state="the sheet's normal",
        words="pushes along the sheet's normal",
        fields=lambda one: [one.states.normal],
    ),
    *_speed_laws("the speed across the sheet", "across the sheet", _across),
    *_speed_laws("the speed along the sheet", "along the sheet", _along),
    Law(
        state="the speed either way",
        words="grows with the square of the speed and points the same way to and fro",
        fields=_even,
    ),
    Law(
        state="the acceleration",
        words="{resists} the acceleration",
        vaguely="{resists} the acceleration",
        fields=lambda one: [_acceleration(one)],
    ),
    Law(
        state="the acceleration",
        words="{resists} the acceleration across the sheet",
        vaguely="{resists} the acceleration",
        fields=lambda one: [_across(one, _acceleration(one))],
    ),
    Law(
        state="the curvature",
        words="pushes along the normal in proportion to the curvature",
        vaguely="is another where the cloth is bent",
        fields=lambda one: [one.states.curvature_1_m[..., k, None] * one.states.normal for k in range(2)],
    ),
    Law(
        state="the strain",
        words="pulls along the threads in proportion to the strain",
        vaguely="is another where the cloth is strained",
        fields=lambda one: [one.states.strain[..., k, None] * one.states.threads[:, :, k] for k in range(2)],
    ),
    Law(
        state=TABLE,
        words="pushes up or down on the table",
        vaguely="acts on the table",
        fields=lambda one: [_touches(one)[..., None] * AXES[2]],
    ),
    Law(
        state=TABLE,
        words="{brakes} by as much at any speed on the table",
        vaguely="acts on the table",
        fields=lambda one: [_touches(one)[..., None] * _power(one.velocity_m_s * (1.0 - AXES[2]), 0)],
        reverses=True,
    ),
)


@dataclass(frozen=True, kw_only=True)
class Strength:
    """A state with which a force may be stronger or weaker."""

    state: str
    words: str  # where there is more of the state
    value: Callable[[Forces, Place], np.ndarray]  # (T, M)


STRENGTHS = (
    Strength(state=TABLE, words="on the table", value=lambda one, _: _touches(one).astype(float)),
    Strength(state="how far along x", words="farther along x", value=lambda one, _: one.path_m[..., 0]),
    Strength(state="how far along y", words="farther along y", value=lambda one, _: one.path_m[..., 1]),
    Strength(state="the height", words="higher up", value=lambda one, _: one.path_m[..., 2]),
    Strength(
        state="the curvature",
        words="where the cloth is bent more",
        value=lambda one, _: np.linalg.norm(one.states.curvature_1_m, axis=-1),
    ),
    Strength(
        state="the strain",
        words="where the cloth is strained more",
        value=lambda one, _: np.linalg.norm(one.states.strain, axis=-1),
    ),
    Strength(
        state="the distance from the grips",
        words="farther from the grips",
        value=lambda one, _: one.states.grip_m,
    ),
    Strength(
        state="the place on the cloth",
        words="in one place of the cloth",
        value=lambda one, place: np.broadcast_to(place.astype(float), one.force_n.shape[:2]),
    ),
)
