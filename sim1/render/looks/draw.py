"""Drawing an appearance from the files of looks: one fabric, one table, one room.

A name is drawn by giving every name a random number of its own and taking the largest, so that another entry's change or
addition leaves most appearances as they were, and their frames with them.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from sim1.render.appearance import SCANNED, Appearance, Color, Fabric, Table
from sim1.render.looks import cloth_colors, surface_colors
from sim1.render.looks.colors import encoded, linear
from sim1.render.looks.fabrics import FabricEntry, read_fabrics
from sim1.render.looks.rooms import RoomEntry, read_rooms
from sim1.render.looks.surfaces import TableEntry, read_tables
from sim1.stage import BadInput

FILES = ("fabrics.yaml", "tables.yaml", "rooms.yaml")
MIN_CONTRAST = 0.3  # between the mean light of garment and table, distance in sRGB: the garment has to be seen
MIN_PLACE_CONTRAST = 0.2  # between the means of table and of a place of the garment, in a share of places of at least
MIN_SHARE = 0.6
MIRROR_DIMS = 0.5  # metal shows the room: by up to so much darker, in sRGB, than a sheet of its colour
TRIES = 6  # of colours for one table before the next one is tried

type Chance = Callable[..., np.random.Generator]
"""Random stream for a purpose: `sim1.stage.random_stream` with everything but the last names given."""


@dataclass(frozen=True, kw_only=True)
class Looks:
    """Everything that can be drawn."""

    folder: Path
    fabrics: tuple[FabricEntry, ...]
    scanned: FabricEntry
    tables: tuple[TableEntry, ...]
    rooms: tuple[RoomEntry, ...]


class Named(Protocol):
    """Whatever has a name."""

    name: str


def read_looks(folder: Path) -> Looks:
    """Read `fabrics.yaml`, `tables.yaml` and `rooms.yaml` of a folder.

    Raises:
        BadInput: a file or an entry is at fault; names entry, key, value and remedy.
    """
    fabrics, scanned = read_fabrics(folder / FILES[0])
    tables, rooms = read_tables(folder / FILES[1]), read_rooms(folder / FILES[2])
    return Looks(folder=folder, fabrics=fabrics, scanned=scanned, tables=tables, rooms=rooms)


def draw_appearance(
    chance: Chance, looks: Looks, *, scanned: np.ndarray, scanned_share: float, elevation_jitter_rad: float
) -> Appearance:
    """Draw a look in which the garment stands out from the table.

    Args:
        chance: source of randomness.
        looks: what there is to draw from.
        scanned: sRGB colours (n, 3) of places all over the garment's measured texture.
        scanned_share: probability in [0, 1] of keeping that texture.
        elevation_jitter_rad: largest change of the head camera's elevation.

    Raises:
        BadInput: no table stands out from the fabric that was drawn.
    """
    if chance("keep").random() < scanned_share:
        mean: Color = tuple(encoded(linear(scanned).mean(axis=0)).tolist())
        fabric = looks.scanned.draw(chance("fabric", SCANNED), (mean,) * 3)
    else:
        chosen = _shuffled(looks.fabrics, chance, "fabric")[0]
        fabric = chosen.draw(chance("fabric", chosen.name))
    room = _shuffled(looks.rooms, chance, "room")[0]
    return Appearance(
        fabric=fabric,
        table=_draw_table(chance, looks, fabric, scanned),
        room=room.draw(chance("room", room.name)),
        elevation_offset_rad=float(chance("camera").uniform(-elevation_jitter_rad, elevation_jitter_rad)),
    )


def stands_out(fabric: Fabric, table: Table, scanned: np.ndarray | None = None) -> bool:
    """Whether the garment can be seen: its mean differs from the table's, and so does most of it, not its dots alone.

    Args:
        fabric: of the garment.
        table: that it lies on.
        scanned: sRGB colours (n, 3) of the measured texture, if the fabric is that.
    """
    light = cloth_colors.shown_light(fabric, scanned)
    return bool(
        _distances(encoded(light.mean(axis=0)), table) >= MIN_CONTRAST
        and (_distances(encoded(light), table) >= MIN_PLACE_CONTRAST).mean() >= MIN_SHARE
    )


def _distances(colors: np.ndarray, table: Table) -> np.ndarray:
    """Distances (...) of colours (..., 3) from what the table shows."""
    brightness = np.linspace(1.0 - MIRROR_DIMS * table.surface.metallic, 1.0, 6)
    shown = brightness[:, None] * surface_colors.mean_color(table.surface)
    return np.linalg.norm(colors[..., None, :] - shown, axis=-1).min(axis=-1)


def _draw_table(chance: Chance, looks: Looks, fabric: Fabric, scanned: np.ndarray) -> Table:
    for entry in _shuffled(looks.tables, chance, "table"):
        stream = chance("table", entry.name)
        for _ in range(TRIES):
            table = entry.draw(stream)
            if stands_out(fabric, table, scanned):
                return table
    raise BadInput(
        f"{looks.folder / FILES[1]}: no table stands out from fabric {fabric.name}, by {MIN_CONTRAST:g} from its mean and by "
        f"{MIN_PLACE_CONTRAST:g} from {100 * MIN_SHARE:.0f} % of its places (distance of sRGB colours); its mean colour is {', '.join(f'{value:.2f}' for value in cloth_colors.mean_color(fabric))}; "
        "add a dark and a bright table"
    )


def _shuffled[T: Named](entries: Iterable[T], chance: Chance, what: str) -> list[T]:
    return sorted(entries, key=lambda entry: (-chance(what, "choice", entry.name).random(), entry.name))
