"""The triangles that a lab hands over: uneven, as those of a scan: inside the rim, what grips hold alone lies on the laboratory's nodes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.concealed.motions.motion import Motion
from benchmarks.concealed.setting import Setting

SCATTER = 0.2
"""Of the spacing: how far a vertex may lie off an even net, along each side; no triangle keeps less than a fifth of its area."""


@dataclass(frozen=True)
class Mesh:
    """The bundle's mesh, flat. Vertices are numbered row by row."""

    uv_m: np.ndarray
    """(V, 2) material coordinates."""
    faces: np.ndarray
    """(F, 3), all u x v upwards."""

    def anchors(self, uv_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Triangle (M,) and barycentric coordinates (M, 3) of material points (M, 2)."""
        corner = self.uv_m[self.faces]
        edges = np.swapaxes(corner[:, 1:] - corner[:, :1], 1, 2)
        part = np.einsum("fij,mfj->mfi", np.linalg.inv(edges), uv_m[:, None] - corner[None, :, 0])
        all_parts = np.concatenate([1 - part.sum(axis=2, keepdims=True), part], axis=2)
        face = all_parts.min(axis=2).argmax(axis=1)
        return face, all_parts[np.arange(len(uv_m)), face]


def draw_mesh(setting: Setting, motions: Sequence[Motion], rng: np.random.Generator) -> Mesh:
    """An even net whose vertices are scattered, but for those that any of the motions holds; the rim stays straight."""
    columns, rows = setting.columns, setting.rows
    row, column = np.divmod(np.arange(columns * rows), columns)
    off = rng.uniform(-SCATTER, SCATTER, (len(row), 2))
    off[(column == 0) | (column == columns - 1), 0] = 0.0
    off[(row == 0) | (row == rows - 1), 1] = 0.0
    off[[vertex for motion in motions for block in motion.blocks for vertex in block.vertices(columns)]] = 0.0
    spacing = np.array([setting.cloth.size_u_m / (columns - 1), setting.cloth.size_v_m / (rows - 1)])
    return Mesh(np.round((np.stack([column, row], axis=1) + off) * spacing, 6), _faces(columns, rows))


def _faces(columns: int, rows: int) -> np.ndarray:
    """(F, 3) triangles, all u x v upwards; the diagonals alternate."""
    faces = []
    for row in range(rows - 1):
        for column in range(columns - 1):
            a = row * columns + column
            b, c, d = a + 1, a + columns, a + columns + 1
            faces += [(a, b, d), (a, d, c)] if (row + column) % 2 == 0 else [(a, b, c), (b, d, c)]
    return np.array(faces)
