"""One rendered frame: whether it is a picture of the size that was asked for, and whether anything is lit in it."""

from pathlib import Path

import numpy as np
from PIL import Image

MIN_MEAN, MAX_MEAN = 6.0, 249.0  # grey levels of 255: neither black nor burnt out
MIN_SPREAD = 4.0  # standard deviation in a frame, grey levels: not one colour


def read_frame(path: Path, *, width: int, height: int) -> np.ndarray | None:
    """Grey levels (height, width, 3); None where the file is damaged or of another size."""
    try:
        with Image.open(path) as image:
            pixels = np.asarray(image.convert("RGB"), float)
    except (OSError, SyntaxError):  # Pillow says the latter of some damaged PNG files
        return None
    return pixels if pixels.shape == (height, width, 3) else None


def is_lit(image: np.ndarray) -> bool:
    """Whether grey levels (height, width, 3) are those of a picture: neither black, burnt out nor of one colour."""
    return MIN_MEAN <= image.mean() <= MAX_MEAN and image.std() >= MIN_SPREAD
