"""The rooms of `data/appearance/rooms.yaml`: every layout in every light and every palette, read strictly, drawn from."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np

from sim1.render.appearance import Color, Glow, Lamp, Piece, Room
from sim1.render.looks.blocks import Block, Limits, Whole
from sim1.render.looks.colors import HUE_DEG, ColorEntry, draw_palette, hsv, read_color
from sim1.render.looks.furniture import FURNITURE
from sim1.render.looks.reading import BlockEntry, Entry, Range, WholeRange, read_entries
from sim1.render.looks.sky import GLOWS
from sim1.render.looks.surfaces import SurfaceEntry, read_surface

SCHEMA = "sim1.rooms/1"
JOINT = "-"  # between the names of layout, light and palette
ROOM_M: Limits = (3.0, 12.0)
LEVEL: Limits = (0.05, 5.0)
PLACE: dict[str, Limits] = {"bearing_deg": (-360.0, 360.0), "gap_m": (0.0, 4.0)}
LIGHT: dict[str, Limits | Whole] = {
    "count": Whole(range(7)),
    "share": (0.0, 100.0),
    "hue_deg": HUE_DEG,
    "saturation": (0.0, 1.0),
}
LAMP: dict[str, Limits] = {"elevation_deg": (20.0, 90.0), "distance_m": (0.8, 3.0), "side_m": (0.05, 2.0)}
AGAINST_WALLS_RAD = 0.1  # standard deviation of a table's direction from that of the walls


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Size and furniture."""

    width_m: Range
    depth_m: Range
    furniture: tuple[BlockEntry, ...]  # with bearing_deg and gap_m


@dataclass(frozen=True, kw_only=True)
class Light:
    """Where light comes from."""

    level: Range  # luminance of a white sheet on the table, with nothing in between
    glows: tuple[BlockEntry, ...]  # with count, share, hue_deg and saturation
    lamps: tuple[Mapping[str, Range | WholeRange], ...]  # the same and LAMP


@dataclass(frozen=True, kw_only=True)
class PaletteEntry:
    """Colours and materials."""

    walls: ColorEntry
    floor: SurfaceEntry
    furniture: tuple[ColorEntry, ...]  # bodies, tops, details


@dataclass(frozen=True, kw_only=True)
class RoomEntry:
    """One room of the file."""

    name: str  # layout-light-palette
    layout: Layout
    light: Light
    palette: PaletteEntry

    def draw(self, stream: np.random.Generator) -> Room:
        yaw_rad = float(stream.integers(0, 4) * np.pi / 2.0 + stream.normal(0.0, AGAINST_WALLS_RAD))
        size_m = (self.layout.width_m.draw(stream), self.layout.depth_m.draw(stream))
        furniture = tuple(_piece(entry.draw(stream)) for entry in self.layout.furniture)
        walls, floor = self.palette.walls.draw(stream), self.palette.floor.draw(stream)
        colors = draw_palette(self.palette.furniture, stream)
        glows, lamps = _lights(self.light, stream)
        return Room(
            name=self.name,
            yaw_rad=yaw_rad,
            size_m=size_m,
            walls=walls,
            floor=floor,
            furniture=furniture,
            furniture_colors=colors,
            glows=glows,
            lamps=lamps,
        )


def read_rooms(path: Path) -> tuple[RoomEntry, ...]:
    """Rooms of the file.

    Raises:
        BadInput: the file or an entry is at fault; names entry, key, value and remedy.
    """
    top = read_entries(path, SCHEMA, "layouts", "lights", "palettes")
    layouts, lights, palettes = (
        {name: read(entry) for name, entry in _named(top[part]).items()}
        for part, read in (("layouts", _layout), ("lights", _light), ("palettes", _palette))
    )
    return tuple(
        RoomEntry(name=JOINT.join(names), layout=layouts[names[0]], light=lights[names[1]], palette=palettes[names[2]])
        for names in product(layouts, lights, palettes)
    )


def light_of(name: str) -> str:
    """The light's name in a room's."""
    return name.split(JOINT)[1]


def lit_as(room: Room, other: Room) -> Room:
    """The room in the other one's light, and named so."""
    layout, _, palette = room.name.split(JOINT)
    return replace(room, name=JOINT.join((layout, light_of(other.name), palette)), glows=other.glows, lamps=other.lamps)


def _named(entry: Entry) -> dict[str, Entry]:
    """The parts' names; one with a hyphen could give two rooms the same name."""
    found = entry.named()
    for name, part in found.items():
        if JOINT in name:
            raise part.fault(f"the name {name!r} has the {JOINT!r} that joins names; write '_' in its place")
    return found


def _layout(entry: Entry) -> Layout:
    fields = entry.fields(("width_m", "depth_m", "furniture"))
    return Layout(
        width_m=fields["width_m"].range(ROOM_M),
        depth_m=fields["depth_m"].range(ROOM_M),
        furniture=tuple(each.block(FURNITURE, PLACE) for each in fields["furniture"].listed(0, 20)),
    )


def _light(entry: Entry) -> Light:
    fields = entry.fields(("level", "glows"), ("lamps",))
    lamps = []
    for each in fields["lamps"].listed(0, 6) if "lamps" in fields else ():
        numbers = each.fields((*LIGHT, *LAMP))
        lamps.append({key: numbers[key].range(limits) for key, limits in (LIGHT | LAMP).items()})
    glows = tuple(each.block(GLOWS, LIGHT) for each in fields["glows"].listed(1, 6))
    certain = [glow for glow in glows if glow.ranges["count"].low >= 1.0 and glow.ranges["share"].low > 0.0]
    if not certain:
        raise fields["glows"].fault("no glow is always there; give one a count of 1 and a share above 0")
    return Light(level=fields["level"].range(LEVEL), glows=glows, lamps=tuple(lamps))


def _palette(entry: Entry) -> PaletteEntry:
    fields = entry.fields(("walls", "floor", "furniture"))
    return PaletteEntry(
        walls=read_color(fields["walls"]),
        floor=read_surface(fields["floor"]),
        furniture=tuple(read_color(each) for each in fields["furniture"].listed(3, 3)),
    )


def _piece(block: Block) -> Piece:
    sizes = {name: value for name, value in block.values.items() if name not in PLACE}
    return Piece(
        shape=Block(kind=block.kind, values=sizes),
        bearing_rad=float(np.radians(block.values["bearing_deg"])),
        gap_m=block.values["gap_m"],
    )


def _lights(light: Light, stream: np.random.Generator) -> tuple[tuple[Glow, ...], tuple[Lamp, ...]]:
    """Draw the lights; their shares are scaled such that all levels add up to the level that is drawn."""
    level = light.level.draw(stream)
    glows = [entry.draw(stream) for entry in light.glows for _ in range(int(entry.ranges["count"].draw(stream)))]
    lamps = [
        {key: span.draw(stream) for key, span in lamp.items()}
        for lamp in light.lamps
        for _ in range(int(lamp["count"].draw(stream)))
    ]
    scale = level / sum(values["share"] for values in (*(glow.values for glow in glows), *lamps))
    bearings = [float(stream.uniform(0.0, 2.0 * np.pi)) for _ in (*glows, *lamps)]
    return (
        tuple(_glow(glow, bearing, scale) for glow, bearing in zip(glows, bearings)),
        tuple(_lamp(lamp, bearing, scale) for lamp, bearing in zip(lamps, bearings[len(glows) :])),
    )


def _color(values: Mapping[str, float]) -> Color:
    return hsv(values["hue_deg"], values["saturation"], 1.0)


def _glow(block: Block, bearing_rad: float, scale: float) -> Glow:
    shape = {name: value for name, value in block.values.items() if name not in LIGHT}
    return Glow(
        shape=Block(kind=block.kind, values=shape),
        bearing_rad=bearing_rad,
        color=_color(block.values),
        level=block.values["share"] * scale,
    )


def _lamp(values: Mapping[str, float], bearing_rad: float, scale: float) -> Lamp:
    elevation, distance = np.radians(values["elevation_deg"]), values["distance_m"]
    towards = np.array(
        [np.cos(bearing_rad) * np.cos(elevation), np.sin(bearing_rad) * np.cos(elevation), np.sin(elevation)]
    )
    return Lamp(
        position_m=tuple((distance * towards).tolist()),
        side_m=values["side_m"],
        color=_color(values),
        level=values["share"] * scale,
    )
