"""What one rendering of a trajectory looks like: fabric, table, room with its light, and the head camera (paper section 3.4)."""

from dataclasses import asdict, dataclass
from typing import Any

from sim1.render.looks.blocks import Block

type Color = tuple[float, float, float]  # sRGB in [0, 1]
type Palette = tuple[Color, Color, Color]  # base, second, third

SCHEMA = "sim1.appearance/3"  # of appearance.json beside the frames
SCANNED = "scanned"  # name of the fabric that is the garment's measured texture


@dataclass(frozen=True, kw_only=True)
class Fabric:
    """Look of the garment."""

    name: str  # of fabrics.yaml, or SCANNED
    colors: Palette  # of SCANNED the mean of the texture, thrice
    pattern: Block
    dye: Block
    weave: Block
    turn_rad: float  # of the threads in the garment's plane
    thread_m: float  # from one thread to the next
    relief_m: float  # height of the weave
    shade: float  # how much darker its hollows are
    weft: float  # how much of the second colour is in the weft
    roughness: float
    sheen: float  # weight of the fuzz lobe
    seed: int


@dataclass(frozen=True, kw_only=True)
class Surface:
    """Look of a table top or a floor."""

    colors: Palette
    figure: Block
    joints: Block
    tone: float  # by how much the brightness of pieces differs
    roughness: float
    metallic: float
    coat: float  # weight of a clear varnish
    seed: int


@dataclass(frozen=True, kw_only=True)
class Table:
    """Look of the table top."""

    name: str  # of tables.yaml
    surface: Surface


@dataclass(frozen=True, kw_only=True)
class Glow:
    """Light from far away: windows, sun, ceiling, walls."""

    shape: Block  # kind in `sim1.render.looks.sky.GLOWS`
    bearing_rad: float  # where it comes from
    color: Color
    level: float  # luminance of a white sheet on the table that it alone lights, with nothing in between


@dataclass(frozen=True, kw_only=True)
class Lamp:
    """A square area light that looks at the table's middle."""

    position_m: tuple[float, float, float]
    side_m: float
    color: Color
    level: float  # as of a glow


@dataclass(frozen=True, kw_only=True)
class Piece:
    """Furniture that faces the table."""

    shape: Block  # kind in `sim1.render.looks.furniture.FURNITURE`
    bearing_rad: float  # as seen from the table, in the room
    gap_m: float  # from the circle about the table to the piece's front


@dataclass(frozen=True, kw_only=True)
class Room:
    """What surrounds the table, and its light."""

    name: str  # layout-light-palette of rooms.yaml
    yaw_rad: float  # of the room about the table
    size_m: tuple[float, float]  # of the floor, at least
    walls: Color
    floor: Surface
    furniture: tuple[Piece, ...]
    furniture_colors: Palette  # bodies, tops and details
    glows: tuple[Glow, ...]
    lamps: tuple[Lamp, ...]


@dataclass(frozen=True, kw_only=True)
class Appearance:
    """One look of the cell."""

    fabric: Fabric
    table: Table
    room: Room
    elevation_offset_rad: float  # of the head camera, about the middle of the table

    def to_json(self) -> dict[str, Any]:
        return asdict(self)
