"""What varies between two renderings of one trajectory: fabric, table, light and head camera (paper section 3.4)."""

import colorsys
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

type Color = tuple[float, float, float]  # sRGB in [0, 1]

FABRICS = ("plain", "stripes", "checks", "dots")
TABLES = ("wood", "plain", "marble")
MIN_CONTRAST = 0.3  # between the means of garment and table, sRGB distance: the garment has to be seen
MAX_ATTEMPTS = 200


@dataclass(frozen=True, kw_only=True)
class Fabric:
    """Look of the garment; `scanned` keeps the texture that was measured."""

    kind: Literal["scanned", "plain", "stripes", "checks", "dots"]
    base: Color
    accent: Color  # second colour of a pattern
    period_m: float  # of the pattern
    angle_rad: float  # of the pattern in the garment's plane
    roughness: float
    sheen: float  # weight of the fuzz lobe
    bump_m: float  # height of the weave


@dataclass(frozen=True, kw_only=True)
class Table:
    """Look of the table top."""

    kind: Literal["wood", "plain", "marble"]
    base: Color
    accent: Color  # of grain or veins
    grain_m: float
    roughness: float


@dataclass(frozen=True, kw_only=True)
class Lamp:
    """A square area light that looks at the table's middle."""

    position_m: tuple[float, float, float]
    side_m: float
    power_w: float
    color: Color


@dataclass(frozen=True, kw_only=True)
class Appearance:
    """One look of the cell."""

    fabric: Fabric
    table: Table
    lamps: tuple[Lamp, ...]
    sky: Color
    sky_strength: float
    floor: Color
    elevation_offset_rad: float  # of the head camera, about the middle of the table

    def to_json(self) -> dict[str, Any]:
        return asdict(self)


def draw_appearance(
    stream: np.random.Generator, *, scanned: Color, scanned_share: float, elevation_jitter_rad: float
) -> Appearance:
    """Draw a look in which the garment stands out from the table.

    Args:
        stream: source of randomness.
        scanned: mean sRGB colour of the garment's measured texture.
        scanned_share: probability in [0, 1] of keeping that texture.
        elevation_jitter_rad: largest change of the head camera's elevation.
    """
    fabric = _draw_fabric(stream, scanned, scanned_share)
    return Appearance(
        fabric=fabric,
        table=_draw_table(stream, fabric),
        lamps=tuple(_draw_lamp(stream) for _ in range(stream.integers(1, 4))),
        sky=_hsv(stream.uniform(0.0, 1.0), stream.uniform(0.0, 0.12), 1.0),
        sky_strength=float(stream.uniform(0.3, 0.7)),
        floor=_hsv(stream.uniform(0.0, 1.0), stream.uniform(0.0, 0.2), stream.uniform(0.15, 0.6)),
        elevation_offset_rad=float(stream.uniform(-elevation_jitter_rad, elevation_jitter_rad)),
    )


def mean_color(fabric: Fabric) -> Color:
    """Mean sRGB colour that the fabric shows."""
    share = {"stripes": 0.5, "checks": 0.5, "dots": 0.2}.get(fabric.kind, 0.0)
    return tuple((1.0 - share) * base + share * accent for base, accent in zip(fabric.base, fabric.accent))


def _draw_fabric(stream: np.random.Generator, scanned: Color, scanned_share: float) -> Fabric:
    kind = "scanned" if stream.random() < scanned_share else str(stream.choice(FABRICS))
    base = _hsv(stream.random(), stream.uniform(0.05, 0.85), stream.uniform(0.25, 0.95))
    hue, saturation, value = colorsys.rgb_to_hsv(*base)
    accent = _hsv(hue + stream.uniform(0.1, 0.9), saturation * stream.uniform(0.2, 1.0), 0.95 if value < 0.6 else 0.2)
    return Fabric(
        kind=kind,
        base=scanned if kind == "scanned" else base,
        accent=accent,
        period_m=float(stream.uniform(0.02, 0.08)),
        angle_rad=float(stream.choice([0.0, np.pi / 2.0]) + stream.normal(0.0, 0.02)),
        roughness=float(stream.uniform(0.7, 1.0)),
        sheen=float(stream.uniform(0.0, 0.4)),
        bump_m=float(stream.uniform(0.0, 5e-4)),
    )


def _draw_table(stream: np.random.Generator, fabric: Fabric) -> Table:
    """Draw until the table contrasts with the garment; some colour always does, as black and white are in reach."""
    kind = str(stream.choice(TABLES))
    garment = np.asarray(mean_color(fabric))
    for _ in range(MAX_ATTEMPTS):
        if kind == "wood":
            base = _hsv(stream.uniform(0.05, 0.11), stream.uniform(0.3, 0.7), stream.uniform(0.2, 0.8))
        elif kind == "marble":
            base = _hsv(
                stream.random(), stream.uniform(0.0, 0.08), stream.choice([0.1, 0.85]) * stream.uniform(0.9, 1.1)
            )
        else:
            base = _hsv(stream.random(), stream.uniform(0.0, 0.6), stream.uniform(0.08, 0.95))
        if np.linalg.norm(np.asarray(base) - garment) >= MIN_CONTRAST:
            break
    return Table(
        kind=kind,
        base=base,
        accent=tuple(0.55 * channel if max(base) > 0.3 else 0.3 + 0.7 * channel for channel in base),
        grain_m=float(stream.uniform(0.1, 0.3) if kind == "marble" else stream.uniform(0.02, 0.08)),
        roughness=float(stream.uniform(0.25, 0.8)),
    )


def _draw_lamp(stream: np.random.Generator) -> Lamp:
    azimuth, elevation, distance = stream.uniform(0, 2 * np.pi), stream.uniform(0.6, 1.4), stream.uniform(1.2, 2.2)
    x, y = np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation)
    return Lamp(
        position_m=tuple(float(distance * value) for value in (x, y, np.sin(elevation))),
        side_m=float(stream.uniform(0.3, 1.2)),
        # Illuminance falls with the square of the distance; what varies is the light that arrives.
        power_w=float(stream.uniform(8.0, 22.0) * distance**2),
        color=_hsv(stream.choice([0.09, 0.6]), stream.uniform(0.0, 0.25), 1.0),
    )


def _hsv(hue: float, saturation: float, value: float) -> Color:
    return colorsys.hsv_to_rgb(float(hue) % 1.0, float(np.clip(saturation, 0, 1)), float(np.clip(value, 0, 1)))
