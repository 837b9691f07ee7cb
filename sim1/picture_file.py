"""Saves figures as small PNG files."""

import io
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image

COLORS = 200  # of the palette: photographs on a sheet still look alike, at a third of the size


def save_figure(figure: Figure, path: Path, dpi: float | None = None) -> None:
    """Write a figure as a PNG file with a palette; `dpi` in place of its own. Same figure, same bytes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi or figure.dpi, metadata={"Software": None})
    with Image.open(buffer) as image:
        image.convert("RGB").quantize(COLORS, dither=Image.Dither.NONE).save(path, format="PNG", optimize=True)
