"""The garment mesh of an earlier stage, as far as a scene needs it: shape and colours."""

from pathlib import Path

import numpy as np
from PIL import Image

from sim1.stage import BadInput


def read_garment(folder: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (v, 3) in m, faces (f, 3) and a colour per face (f, 3) in [0, 1] from a `garment_mesh` artifact.

    Raises:
        BadInput: a file is missing or damaged, or faces name vertices that do not exist.
    """
    path = folder / "mesh.npz"
    try:
        with np.load(path, allow_pickle=False) as data:
            vertices, faces, uv = (np.array(data[key]) for key in ("vertices_m", "faces", "uv"))
        with Image.open(folder / "texture.png") as picture:
            texture = np.asarray(picture.convert("RGB"))
    except (OSError, KeyError, ValueError) as error:
        raise BadInput(f"{folder}: not a readable garment mesh ({error}); make garment_mesh again") from error
    shapes_fit = (
        vertices.ndim == 2 and vertices.shape[1:] == (3,) and faces.shape[1:] == (3,) and uv.shape == (len(faces), 3, 2)
    )
    if not shapes_fit or len(faces) == 0 or faces.min() < 0 or faces.max() >= len(vertices):
        raise BadInput(f"{path}: vertices_m {vertices.shape}, faces {faces.shape}, uv {uv.shape} do not fit together")
    if not np.isfinite(vertices).all():
        raise BadInput(f"{path}: vertices_m holds values that are not finite; make garment_mesh again")
    return vertices.astype(float), faces.astype(np.int32), _face_colors(uv, texture)


def _face_colors(uv: np.ndarray, texture: np.ndarray) -> np.ndarray:
    """Texture colour in the middle of each face; v points up, as in OBJ."""
    height, width = texture.shape[:2]
    middle = np.clip(np.nan_to_num(uv.mean(axis=1)), 0, 1)
    column = np.minimum((middle[:, 0] * width).astype(int), width - 1)
    row = np.minimum(((1 - middle[:, 1]) * height).astype(int), height - 1)
    return texture[row, column] / 255.0
