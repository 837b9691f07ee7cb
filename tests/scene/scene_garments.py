"""Small garments in the form of the `garment_mesh` artifact."""

from pathlib import Path

import numpy as np
from PIL import Image


def sheet(corners: np.ndarray) -> np.ndarray:
    """Faces of a grid of points (n, m)."""
    index = np.arange(corners.shape[0] * corners.shape[1]).reshape(corners.shape[:2])
    a, b, c, d = (index[i].ravel() for i in (np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[1:, 1:], np.s_[:-1, 1:]))
    return np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])


def towel_points(width: float = 0.4, length: float = 0.6) -> np.ndarray:
    x, y = np.meshgrid(np.linspace(0, width, 25), np.linspace(0, length, 37), indexing="ij")
    return np.stack([x, y, np.full_like(x, 1.0)], -1)


def shirt_points() -> np.ndarray:
    """Body of a shirt on a mannequin: an upright tube, wide from left to right, narrow at the collar; front +x."""
    angle, z = np.meshgrid(np.linspace(0, 2 * np.pi, 25), np.linspace(0.9, 1.5, 13), indexing="ij")
    width = np.interp(z, [0.9, 1.2, 1.35, 1.5], [0.22, 0.22, 0.27, 0.15])
    return np.stack([0.1 * np.cos(angle), width * np.sin(angle), z], -1)


def write_mesh(folder: Path, grid: np.ndarray) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    faces = sheet(grid)
    uv = np.stack(np.meshgrid(*(np.linspace(0, 1, n) for n in grid.shape[:2]), indexing="ij"), -1).reshape(-1, 2)
    points = grid.reshape(-1, 3).astype(np.float32)
    np.savez(
        folder / "mesh.npz",
        vertices_m=points,
        faces=faces.astype(np.int32),
        uv=uv[faces].astype(np.float32),
        rest_m=points,
    )
    texture = np.zeros((8, 8, 3), np.uint8)
    texture[:4, :, 0] = 255  # upper half, where v > 0.5: red
    texture[4:, :, 2] = 255
    Image.fromarray(texture).save(folder / "texture.png")
    return folder
