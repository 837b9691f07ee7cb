"""Pictures that a LeRobot v3 dataset holds in its tables: features of dtype `image`."""

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from sim1.dataset.check_videos import size_of
from sim1.dataset.tables import Tables
from sim1.stage import Finding


def check_images(root: Path, tables: Tables) -> Finding:
    """Finding `images_readable`: each picture decodes to the height, width and channels of its feature, all values finite.

    A cell holds the file's bytes, as LeRobot's writer leaves them, or a path.
    """
    from sim1.dataset.check import finding

    keys = [name for name, feature in tables.info["features"].items() if feature["dtype"] == "image"]
    faults: list[str] = []
    for key in keys:
        faults += _faults(root, tables, key)
    return finding("images_readable", faults, f"{len(keys) * len(tables.frames)} pictures of {len(keys)} features")


def _faults(root: Path, tables: Tables, key: str) -> Iterator[str]:
    feature = tables.info["features"][key]
    expected = (*size_of(feature), channels_of(feature))
    for row, cell in enumerate(tables.frames[key]):
        try:
            pixels = _pixels(root, cell)
        except Exception as error:  # Pillow raises many kinds of errors on damaged files
            yield f"{tables.place(row)}: {key} cannot be decoded ({' '.join(str(error).split())})"
            continue
        shape = (*pixels.shape, 1)[:3]
        if shape != expected:
            yield f"{tables.place(row)}: {key} is {_text(shape)}, expected {_text(expected)} (height, width, channels)"
        elif not np.isfinite(pixels).all():
            yield f"{tables.place(row)}: {key} has {np.count_nonzero(~np.isfinite(pixels))} values that are not finite"


def _pixels(root: Path, cell: Any) -> np.ndarray:
    """A picture (h, w) or (h, w, c)."""
    if not isinstance(cell, dict):
        raise ValueError(f"the cell is {cell!r:.40}, expected bytes or a path")
    content, path = cell.get("bytes"), cell.get("path")
    if content is None and not path:
        raise ValueError("neither bytes nor a path")
    with Image.open(io.BytesIO(content) if content is not None else root / path) as image:
        image.load()  # NumPy makes no error of what cannot be loaded, and nothing of the picture
        return np.asarray(image)


def channels_of(feature: dict[str, Any]) -> int:
    """Of a picture's feature; LeRobot knows channels before and after height and width, by the names."""
    names, shape = feature.get("names") or (), feature["shape"]
    return shape[0 if len(names) and str(names[0]).startswith("channel") else -1]


def _text(shape: tuple[int, ...]) -> str:
    return " x ".join(map(str, shape))
