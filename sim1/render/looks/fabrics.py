"""The fabrics of `data/appearance/fabrics.yaml`: read strictly, drawn from."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.render.appearance import SCANNED, Color, Fabric
from sim1.render.looks.blocks import Limits
from sim1.render.looks.colors import ColorEntry, draw_palette, read_colors
from sim1.render.looks.dyes import DYES
from sim1.render.looks.patterns import PATTERNS
from sim1.render.looks.reading import BlockEntry, Entry, Range, read_entries
from sim1.render.looks.weaves import WEAVES

SCHEMA = "sim1.fabrics/1"
NUMBERS: dict[str, Limits] = {
    "thread_m": (0.0002, 0.02),
    "relief_m": (0.0, 0.005),
    "shade": (0.0, 1.0),
    "weft": (0.0, 1.0),
    "roughness": (0.0, 1.0),
    "sheen": (0.0, 1.0),
}
OF_SCANNED = ("weave", *NUMBERS)  # colours, pattern and dye are in the measured texture
PLAIN, EVEN = BlockEntry("plain", {}), BlockEntry("even", {})
CUT_RAD = 0.02  # standard deviation of the threads' direction from the garment's: cloth is cut along its threads


@dataclass(frozen=True, kw_only=True)
class FabricEntry:
    """One fabric of the file."""

    name: str
    colors: tuple[ColorEntry, ...]
    pattern: BlockEntry
    dye: BlockEntry
    weave: BlockEntry
    numbers: dict[str, Range]

    def draw(self, stream: np.random.Generator, colors: tuple[Color, Color, Color] | None = None) -> Fabric:
        """Draw a fabric; `colors` takes the place of those that the entry has."""
        return Fabric(
            name=self.name,
            colors=colors or draw_palette(self.colors, stream),
            pattern=self.pattern.draw(stream),
            dye=self.dye.draw(stream),
            weave=self.weave.draw(stream),
            **{name: span.draw(stream) for name, span in self.numbers.items()},
            turn_rad=float(stream.integers(0, 2) * np.pi / 2.0 + stream.normal(0.0, CUT_RAD)),
            seed=int(stream.integers(0, 2**31)),
        )


def read_fabrics(path: Path) -> tuple[tuple[FabricEntry, ...], FabricEntry]:
    """Fabrics of the file, and how the garment's own texture is shown.

    Raises:
        BadInput: the file or an entry is at fault; names entry, key, value and remedy.
    """
    top = read_entries(path, SCHEMA, SCANNED, "fabrics")
    fabrics = tuple(_fabric(name, entry) for name, entry in top["fabrics"].named().items())
    if SCANNED in {fabric.name for fabric in fabrics}:
        raise top["fabrics"].named()[SCANNED].fault("this name is the measured texture's; give another")
    return fabrics, _scanned(top[SCANNED])


def _fabric(name: str, entry: Entry) -> FabricEntry:
    fields = entry.fields(("colors", *OF_SCANNED), ("pattern", "dye"))
    pattern = fields["pattern"].block(PATTERNS) if "pattern" in fields else PLAIN
    dye = fields["dye"].block(DYES) if "dye" in fields else EVEN
    numbers = {key: fields[key].range(limits) for key, limits in NUMBERS.items()}
    needs = {
        f"pattern {pattern.kind}": PATTERNS.color_counts[pattern.kind],
        f"dye {dye.kind}": DYES.color_counts[dye.kind],
        "weft": 2 if numbers["weft"].high > 0.0 else 1,
    }
    return FabricEntry(
        name=name,
        colors=read_colors(fields["colors"], needs),
        pattern=pattern,
        dye=dye,
        weave=fields["weave"].block(WEAVES),
        numbers=numbers,
    )


def _scanned(entry: Entry) -> FabricEntry:
    fields = entry.fields(OF_SCANNED)
    numbers = {key: fields[key].range(limits) for key, limits in NUMBERS.items()}
    if numbers["weft"].high > 0.0:
        raise fields["weft"].fault("a measured texture has no second colour; write 0")
    weave = fields["weave"].block(WEAVES)
    return FabricEntry(name=SCANNED, colors=(), pattern=PLAIN, dye=EVEN, weave=weave, numbers=numbers)
