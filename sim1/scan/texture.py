"""UV charts and a texture baked from the colours of the scan points; textured OBJ."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

_NEAREST = 6  # points averaged in a texel: the scanner's colours are noisy


@dataclass(frozen=True, kw_only=True)
class Texture:
    """Texture coordinates per corner and the image that they point into; v runs upwards, as in OBJ."""

    uv: np.ndarray  # (f, 3, 2) float32 in [0, 1]
    image: np.ndarray  # (size, size, 3) uint8


def bake(vertices_m: np.ndarray, faces: np.ndarray, points_m: np.ndarray, colors: np.ndarray, size: int) -> Texture:
    """Texture of `size` pixels a side for a mesh, from coloured points (n, 3)."""
    import xatlas
    from scipy.ndimage import distance_transform_edt
    from scipy.spatial import cKDTree

    atlas = xatlas.Atlas()
    atlas.add_mesh(vertices_m.astype(np.float32), faces.astype(np.uint32))
    options = xatlas.PackOptions()
    options.resolution, options.padding, options.create_image = size, 2, False
    atlas.generate(pack_options=options)
    _, corners, coordinates = atlas[0]
    uv = coordinates[corners].astype(np.float32)

    rows, columns, place = _texels(uv, vertices_m[faces], size)
    distance, near = cKDTree(points_m).query(place, k=_NEAREST)
    weight = 1.0 / (distance + 5e-4)
    shade = np.einsum("nk,nkc->nc", weight, colors[near].astype(float)) / weight.sum(axis=1, keepdims=True)
    image = np.zeros((size, size, 3), np.uint8)
    image[rows, columns] = np.round(shade)
    filled = np.zeros((size, size), bool)
    filled[rows, columns] = True
    nearest = distance_transform_edt(~filled, return_distances=False, return_indices=True)
    return Texture(uv=uv, image=image[tuple(nearest)])


def _texels(uv: np.ndarray, corners: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows and columns of the texels whose middle a face covers, and where on the mesh they lie (n, 3)."""
    pixels = np.stack([uv[..., 0] * size, (1.0 - uv[..., 1]) * size], axis=-1).astype(float)
    rows, columns, places = [], [], []
    for triangle, corner in zip(pixels, corners, strict=True):
        low = np.maximum(np.floor(triangle.min(axis=0)).astype(int), 0)
        high = np.minimum(np.ceil(triangle.max(axis=0)).astype(int), size)
        x, y = (axis.ravel() for axis in np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1])))
        sides = np.stack([triangle[1] - triangle[0], triangle[2] - triangle[0]], axis=1)
        if abs(np.linalg.det(sides)) < 1e-12:
            continue
        second = np.linalg.solve(sides, np.stack([x + 0.5, y + 0.5]) - triangle[0][:, None])
        weights = np.concatenate([1.0 - second.sum(axis=0, keepdims=True), second])
        inside = (weights > -1e-9).all(axis=0)
        rows.append(y[inside])
        columns.append(x[inside])
        places.append(weights[:, inside].T @ corner)
    return np.concatenate(rows), np.concatenate(columns), np.concatenate(places)


def write_textured_obj(folder: Path, title: str, vertices_m: np.ndarray, faces: np.ndarray, texture: Texture) -> None:
    """Write `garment.obj`, `garment.mtl` and `texture.png`; metres, vertices in the order of the mesh."""
    from PIL import Image

    lines = [f"# {title}; metres, front x, left y, up z", "mtllib garment.mtl", "o garment", "usemtl fabric"]
    lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices_m]
    lines += [f"vt {u:.6f} {v:.6f}" for u, v in texture.uv.reshape(-1, 2)]
    corners = np.arange(1, 3 * len(faces) + 1).reshape(-1, 3)
    lines += [
        "f " + " ".join(f"{v + 1}/{t}" for v, t in zip(face, corner, strict=True))
        for face, corner in zip(faces, corners, strict=True)
    ]
    (folder / "garment.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / "garment.mtl").write_text("newmtl fabric\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd texture.png\n")
    Image.fromarray(texture.image).save(folder / "texture.png", optimize=True)
