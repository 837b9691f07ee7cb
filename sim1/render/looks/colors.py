"""Colours as files give them: ranges of hue, saturation and value."""

import colorsys
from dataclasses import dataclass

import numpy as np

from sim1.render.appearance import Color, Palette
from sim1.render.looks.blocks import Limits
from sim1.render.looks.reading import Entry, Range

HUE_DEG: Limits = (-360.0, 720.0)  # a range may pass 0 or 360, where red is
SHARE: Limits = (0.0, 1.0)
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear red, green and blue (Rec. 709)


@dataclass(frozen=True)
class ColorEntry:
    """A range of colours."""

    hue_deg: Range
    saturation: Range
    value: Range

    def draw(self, stream: np.random.Generator) -> Color:
        hue_deg, saturation, value = (span.draw(stream) for span in (self.hue_deg, self.saturation, self.value))
        return hsv(hue_deg, saturation, value)


def hsv(hue_deg: float, saturation: float, value: float) -> Color:
    """The sRGB colour."""
    return colorsys.hsv_to_rgb(hue_deg / 360.0 % 1.0, saturation, value)


def linear(color: Color | np.ndarray) -> np.ndarray:
    """Linear RGB (..., 3) of sRGB colours (..., 3)."""
    values = np.asarray(color)
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def encoded(light: np.ndarray) -> np.ndarray:
    """The sRGB colours (..., 3) of linear RGB (..., 3) in [0, 1]: what `linear` takes back."""
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 0.0031308) ** (1 / 2.4) - 0.055)


def light_color(color: Color) -> np.ndarray:
    """Linear RGB (3,) of luminance 1 with the hue and saturation of an sRGB colour: what a light of level 1 sends out."""
    light = linear(color)
    return light / (light @ LUMINANCE)


def read_color(entry: Entry) -> ColorEntry:
    """Read `{hue_deg, saturation, value}`. Raises BadInput."""
    fields = entry.fields(("hue_deg", "saturation", "value"))
    return ColorEntry(fields["hue_deg"].range(HUE_DEG), fields["saturation"].range(SHARE), fields["value"].range(SHARE))


def read_colors(entry: Entry, needs: dict[str, int]) -> tuple[ColorEntry, ...]:
    """Read one to three colours; `needs` says how many each block shows.

    Raises:
        BadInput: at fault, or fewer than a block shows.
    """
    colors = tuple(read_color(each) for each in entry.listed(1, 3))
    for block, count in needs.items():
        if count > len(colors):
            raise entry.fault(f"{len(colors)} colours, and {block} shows {count}; add {count - len(colors)}")
    return colors


def draw_palette(colors: tuple[ColorEntry, ...], stream: np.random.Generator) -> Palette:
    """Three colours; the last is repeated where there are fewer."""
    drawn = [color.draw(stream) for color in colors]
    return tuple((drawn + [drawn[-1]] * 3)[:3])
