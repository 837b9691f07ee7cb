"""Pictures of looks in Blender's memory: nothing is read from or written to a file. Imported by the worker alone.

Pictures are finer the wider the frames are: a frame of few points shows no thread.
"""

from collections.abc import Callable

import bpy  # noqa: TID253  only the worker's process gets here
import numpy as np

from sim1.render.appearance import Fabric, Room, Surface
from sim1.render.looks.cloth_colors import cloth_colors
from sim1.render.looks.sky import sky
from sim1.render.looks.surface_colors import surface_colors
from sim1.render.looks.weaves import weave_tile

PER_FRAME_WIDTH = 4  # points of a picture for one of the frame's width: what it shows may fill a quarter of it
LEAST, MOST = 128, 2048  # points of a picture's side
TILE_POINTS = 512  # of a weave's tile


def picture_points(frame_width: int) -> int:
    """Points along the longer side of a picture."""
    return int(np.clip(PER_FRAME_WIDTH * frame_width, LEAST, MOST))


def fabric_image(fabric: Fabric, low_m: np.ndarray, high_m: np.ndarray, points: int) -> bpy.types.Image:
    """Colours of the fabric over a rectangle of the garment's plane, corners `low_m` and `high_m` (2,)."""
    middle = 0.5 * (low_m + high_m)
    return _painted("fabric", lambda x, y: cloth_colors(fabric, x - middle[0], y - middle[1]), low_m, high_m, points)


def surface_image(name: str, surface: Surface, low_m: np.ndarray, high_m: np.ndarray, points: int) -> bpy.types.Image:
    """Colours of a table top or a floor over a rectangle, corners `low_m` and `high_m` (2,)."""
    return _painted(name, lambda x, y: surface_colors(surface, x, y), low_m, high_m, points)


def weave_image(fabric: Fabric) -> bpy.types.Image:
    """One tile of the weave: height in the red channel, weft in the green one."""
    height, weft = weave_tile(fabric.weave, TILE_POINTS)
    return _image("weave", np.stack([height, weft, np.zeros_like(height)], axis=-1), space="Non-Color")


def sky_image(room: Room) -> bpy.types.Image:
    """Linear radiance of all directions."""
    return _image("sky", sky(room), space="Linear Rec.709", of_floats=True)


def _painted(
    name: str,
    paint: Callable[[np.ndarray, np.ndarray], np.ndarray],
    low_m: np.ndarray,
    high_m: np.ndarray,
    points: int,
) -> bpy.types.Image:
    size = np.maximum(high_m - low_m, 1e-3)
    counts = np.maximum(np.round(points * size / size.max()), 2).astype(int)
    x, y = (low + (np.arange(count) + 0.5) * side / count for low, count, side in zip(low_m, counts, size))
    return _image(name, paint(*np.meshgrid(x, y)), space="sRGB")


def _image(name: str, colors: np.ndarray, *, space: str, of_floats: bool = False) -> bpy.types.Image:
    """An image of colours (rows, columns, 3), the first row at the bottom."""
    rows, columns, _ = colors.shape
    image = bpy.data.images.new(name, columns, rows, float_buffer=of_floats)
    image.colorspace_settings.name = space
    whole = np.ones((rows, columns, 4), np.float32)
    whole[..., :3] = colors
    image.pixels.foreach_set(whole.ravel())
    image.update()
    return image
