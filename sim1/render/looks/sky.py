"""The light that comes from far away, as a picture of all directions: windows, sun, ceiling panels, walls.

A picture has `rows` rows from straight down to straight up and twice as many columns around; the first one looks along -x, that
at a quarter along +y and the middle one along +x, as Blender reads an equirectangular world. Radiances are linear and scaled such
that every glow lights a white sheet on the table by its own `level`, whatever its colour: a level is a luminance.
"""

from dataclasses import dataclass

import numpy as np

from sim1.render.appearance import Room
from sim1.render.looks.blocks import Kinds, Limits
from sim1.render.looks.colors import light_color, linear
from sim1.render.looks.noise import step
from sim1.render.looks.turns import about_z
from sim1.stage import BadInput

ELEVATION: Limits = (0.0, 90.0)  # deg; what lies below lights no table
WIDTH: Limits = (6.0, 180.0)  # deg; a narrower one would fall between the picture's points
SOFT_DEG = 2.0  # of an edge
FLOOR_SHARE = 0.25  # of the light from above that a floor sends back
GLOWS = Kinds("glow")


@dataclass(frozen=True)
class Directions:
    """Unit directions (rows, columns, 3) of a picture and the solid angle [sr] (rows, 1) of its points."""

    to: np.ndarray
    solid_angle: np.ndarray


def directions(rows: int) -> Directions:
    """Middle of every point of a picture with `rows` rows."""
    elevation = (np.arange(rows) + 0.5) / rows * np.pi - 0.5 * np.pi
    bearing = np.pi - (np.arange(2 * rows) + 0.5) / rows * np.pi
    across, up = np.cos(elevation)[:, None], np.sin(elevation)[:, None]
    to = np.stack([across * np.cos(bearing), across * np.sin(bearing), np.broadcast_to(up, (rows, 2 * rows))], axis=-1)
    return Directions(to, across * (np.pi / rows) ** 2)


def sky(room: Room, rows: int = 128) -> np.ndarray:
    """Linear radiance (rows, 2 * rows, 3), float32.

    Raises:
        BadInput: a glow is too small for a picture with `rows` rows.
    """
    around = directions(rows)
    weight = np.clip(around.to[..., 2], 0.0, None) * around.solid_angle / np.pi  # of a horizontal white sheet
    total = np.zeros_like(around.to)
    for glow in room.glows:
        shape = GLOWS.make(glow.shape, around.to @ about_z(glow.bearing_rad))  # as seen along the bearing
        own = (shape * weight).sum()
        if not own > 0.0:
            raise BadInput(
                f"room {room.name}: glow {glow.shape.kind} of {dict(glow.shape.values)} lies between the {rows} rows of the sky's "
                "picture and would light nothing; make it wider or higher"
            )
        total += glow.level * shape[..., None] / own * light_color(glow.color)
    above = (total * weight[..., None]).sum(axis=(0, 1))
    floor = above * FLOOR_SHARE * linear(room.floor.colors[0])
    return (total + np.where(around.to[..., 2:] < 0.0, floor, 0.0)).astype(np.float32)


@GLOWS.kind()
def ambient(to: np.ndarray) -> np.ndarray:
    """From everywhere above, most of it from the ceiling: what walls send on."""
    return np.where(to[..., 2] > 0.0, 0.4 + 0.6 * to[..., 2], 0.0)


@GLOWS.kind(elevation_deg=ELEVATION, width_deg=WIDTH, height_deg=WIDTH)
def window(to: np.ndarray, *, elevation_deg: float, width_deg: float, height_deg: float) -> np.ndarray:
    """A rectangle of sky with a cross of bars."""
    bearing = np.degrees(np.arctan2(to[..., 1], to[..., 0]))
    elevation = np.degrees(np.arcsin(np.clip(to[..., 2], -1.0, 1.0))) - elevation_deg
    pane = _inside(bearing, 0.5 * width_deg) * _inside(elevation, 0.5 * height_deg)
    return pane * (1.0 - 0.9 * np.maximum(_inside(bearing, 0.0), _inside(elevation, 0.0)))


@GLOWS.kind(elevation_deg=(15.0, 85.0), width_deg=(6.0, 30.0))
def sun(to: np.ndarray, *, elevation_deg: float, width_deg: float) -> np.ndarray:
    """A disc, wider than the sun: through a curtain, or a spotlight."""
    elevation = np.radians(elevation_deg)
    cosine = to @ np.array([np.cos(elevation), 0.0, np.sin(elevation)])
    return _inside(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))), 0.5 * width_deg)


# A panel farther off than two heights can be thinner than a row of the picture is high.
@GLOWS.kind(offset=(-2.0, 2.0), width=(0.1, 3.0), length=(0.1, 6.0))
def panel(to: np.ndarray, *, offset: float, width: float, length: float) -> np.ndarray:
    """A rectangle on the ceiling; place and size in heights of the ceiling above the table."""
    up = np.where(to[..., 2] > 0.02, to[..., 2], np.nan)
    x, y = to[..., 0] / up - offset, to[..., 1] / up
    return np.nan_to_num(step(0.05, -0.05, np.abs(x) - 0.5 * width) * step(0.05, -0.05, np.abs(y) - 0.5 * length))


def _inside(angle_deg: np.ndarray, half_deg: float) -> np.ndarray:
    return step(half_deg + SOFT_DEG, half_deg - 0.5 * SOFT_DEG, np.abs(angle_deg))
