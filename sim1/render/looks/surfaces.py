"""Surfaces of tables and floors, and the tables of `data/appearance/tables.yaml`: read strictly, drawn from."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.render.appearance import Surface, Table
from sim1.render.looks.blocks import Limits
from sim1.render.looks.colors import ColorEntry, draw_palette, read_colors
from sim1.render.looks.figures import FIGURES
from sim1.render.looks.joints import JOINTS
from sim1.render.looks.reading import BlockEntry, Entry, Range, read_entries

SCHEMA = "sim1.table_looks/1"
SHARE: Limits = (0.0, 1.0)
DEFAULTS = {"tone": Range(0.0, 0.0), "metallic": Range(0.0, 0.0), "coat": Range(0.0, 0.0)}
WHOLE = BlockEntry("none", {})


@dataclass(frozen=True, kw_only=True)
class SurfaceEntry:
    """A surface of a file."""

    colors: tuple[ColorEntry, ...]
    figure: BlockEntry
    joints: BlockEntry
    numbers: dict[str, Range]

    def draw(self, stream: np.random.Generator) -> Surface:
        return Surface(
            colors=draw_palette(self.colors, stream),
            figure=self.figure.draw(stream),
            joints=self.joints.draw(stream),
            **{name: span.draw(stream) for name, span in self.numbers.items()},
            seed=int(stream.integers(0, 2**31)),
        )


@dataclass(frozen=True, kw_only=True)
class TableEntry:
    """One table of the file."""

    name: str
    surface: SurfaceEntry

    def draw(self, stream: np.random.Generator) -> Table:
        return Table(name=self.name, surface=self.surface.draw(stream))


def read_surface(entry: Entry) -> SurfaceEntry:
    """Read a surface. Raises BadInput, which names entry, key, value and remedy."""
    fields = entry.fields(("colors", "figure", "roughness"), ("joints", *DEFAULTS))
    figure = fields["figure"].block(FIGURES)
    numbers = {key: fields[key].range(SHARE) for key in ("roughness", *DEFAULTS) if key in fields}
    return SurfaceEntry(
        colors=read_colors(fields["colors"], {f"figure {figure.kind}": FIGURES.color_counts[figure.kind]}),
        figure=figure,
        joints=fields["joints"].block(JOINTS) if "joints" in fields else WHOLE,
        numbers={**DEFAULTS, **numbers},
    )


def read_tables(path: Path) -> tuple[TableEntry, ...]:
    """Tables of the file.

    Raises:
        BadInput: the file or an entry is at fault; names entry, key, value and remedy.
    """
    tables = read_entries(path, SCHEMA, "tables")["tables"].named()
    return tuple(TableEntry(name=name, surface=read_surface(entry)) for name, entry in tables.items())
