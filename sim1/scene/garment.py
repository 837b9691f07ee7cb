"""The garment mesh of an earlier stage, as far as a scene needs it: shape and colours."""

from pathlib import Path

import numpy as np
from PIL import Image

from sim1.array_file import read_numbers
from sim1.stage import BadInput

REMEDY = "make garment_mesh again"


def read_garment(folder: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (v, 3) in m, faces (f, 3) and a colour per face (f, 3) in [0, 1] from a `garment_mesh` artifact.

    Raises:
        BadInput: as `read_textured`.
    """
    vertices, faces, uv, texture = read_textured(folder, "vertices_m")
    return vertices, faces, _face_colors(uv, texture)


def read_textured(folder: Path, shape: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (v, 3) in m, faces (f, 3), their places in the texture (f, 3, 2) and the texture (h, w, 3), 8 bit sRGB, of a `garment_mesh` artifact.

    Args:
        folder: the artifact.
        shape: which vertices: `vertices_m` as scanned, `rest_m` without strain.

    Raises:
        BadInput: a file is missing or damaged, or faces name vertices that do not exist.
    """
    path, picture = folder / "mesh.npz", folder / "texture.png"
    arrays = read_numbers(path, {shape: ("v", 3), "faces": ("f", 3), "uv": ("f", 3, 2)}, "garment mesh", REMEDY)
    vertices, faces = arrays[shape].astype(float), arrays["faces"].astype(np.int32)
    if len(faces) == 0 or faces.min() < 0 or faces.max() >= len(vertices):
        raise BadInput(f"{path}: {len(faces)} faces, not all of them of the {len(vertices)} vertices; {REMEDY}")
    try:
        with Image.open(picture) as image:
            texture = np.asarray(image.convert("RGB"))
    except (OSError, ValueError) as error:
        raise BadInput(f"{picture}: not a readable picture ({error}); {REMEDY}") from error
    return vertices, faces, arrays["uv"], texture


def _face_colors(uv: np.ndarray, texture: np.ndarray) -> np.ndarray:
    """Texture colour in the middle of each face; v points up, as in OBJ."""
    height, width = texture.shape[:2]
    middle = np.clip(uv.mean(axis=1), 0, 1)
    column = np.minimum((middle[:, 0] * width).astype(int), width - 1)
    row = np.minimum(((1 - middle[:, 1]) * height).astype(int), height - 1)
    return texture[row, column] / 255.0
