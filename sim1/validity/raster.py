"""Cheap pictures of the cell: a z-buffer rasteriser in numpy, for filters and policies that look at many frames.

No Blender and no GPU: flat-shaded triangles over an analytically traced table top. Photographs for the dataset are made
by `sim1.render`; these pictures only have to show the shape of the garment as the head camera sees it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from sim1.scene.description import Scene

NEAR_M = 0.02
TABLE_DROP_M = 0.003  # the table is drawn a little low: cloth that rests in it by a contact radius is still seen
BACKGROUND = np.array([52.0, 56.0, 64.0])
TABLE = np.array([168.0, 150.0, 128.0])
GARMENT = np.array([70.0, 120.0, 190.0])
BACK_SIDE = 0.72  # the back of a fabric is shown darker, so that a fold can be told from its outline
AMBIENT = 0.35
LIGHT = np.array([0.3, 0.4, 0.866])  # direction towards the light, unit length, world frame


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A pinhole camera with square pixels and its axis in the middle of the picture."""

    camera_to_world: np.ndarray  # (4, 4) OpenGL: looks along -z, y up
    fy_px: float  # focal length for a picture of `height` pixels
    width: int
    height: int

    def resized(self, width: int, height: int) -> Camera:
        """The same vertical field of view in a picture of another size."""
        scale = height / self.height
        return Camera(camera_to_world=self.camera_to_world, fy_px=self.fy_px * scale, width=width, height=height)

    def project(self, points_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pixel coordinates (n, 2), x to the right and y down, and depth in front of the camera [m] (n,)."""
        rotation, origin = self.camera_to_world[:3, :3], self.camera_to_world[:3, 3]
        local = (points_m - origin) @ rotation
        depth = -local[:, 2]
        safe = np.where(depth > NEAR_M, depth, NEAR_M)
        x = self.fy_px * local[:, 0] / safe + self.width / 2
        y = -self.fy_px * local[:, 1] / safe + self.height / 2
        return np.stack([x, y], axis=-1), depth

    def rays(self) -> np.ndarray:
        """World direction through the middle of every pixel, (height, width, 3), unit depth."""
        x = (np.arange(self.width) + 0.5 - self.width / 2) / self.fy_px
        y = -(np.arange(self.height) + 0.5 - self.height / 2) / self.fy_px
        grid = np.stack([*np.meshgrid(x, y), np.full((self.height, self.width), -1.0)], axis=-1)
        return grid @ self.camera_to_world[:3, :3].T


def render(
    vertices_m: np.ndarray,
    faces: np.ndarray,
    colors: np.ndarray,
    camera: Camera,
    canvas: np.ndarray,
    depth_m: np.ndarray,
) -> None:
    """Draw shaded triangles over `canvas` (h, w, 3) float, with `depth_m` (h, w) as z-buffer; both are changed.

    Args:
        vertices_m: (v, 3) world frame. A triangle that reaches behind the near plane is left out.
        faces: (f, 3).
        colors: (f, 3) or (3,), 0 to 255, before shading.
        camera: its size is that of the canvas.
        canvas: (h, w, 3) float, the picture so far.
        depth_m: (h, w), infinity where nothing was drawn.
    """
    pixels, depth = camera.project(vertices_m.astype(float))
    visible = (depth[faces] > NEAR_M).all(axis=1)
    faces, colors = faces[visible], np.broadcast_to(colors, (len(faces), 3))[visible]
    shades = _shade(vertices_m.astype(float), faces, colors, camera)
    triangle, at, inverse_depth = _covered_pixels(pixels[faces], 1 / depth[faces], camera)
    nearer = inverse_depth * depth_m.ravel()[at] > 1
    triangle, at, inverse_depth = triangle[nearer], at[nearer], inverse_depth[nearer]
    order = np.argsort(inverse_depth, kind="stable")  # the nearest is written last, and stays
    canvas.reshape(-1, 3)[at[order]] = shades[triangle[order]]
    depth_m.ravel()[at[order]] = 1 / inverse_depth[order]


def _shade(vertices_m: np.ndarray, faces: np.ndarray, colors: np.ndarray, camera: Camera) -> np.ndarray:
    """Two-sided Lambert shading, darker where the back of a face is seen: (f, 3)."""
    a, b, c = (vertices_m[faces[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    front = np.einsum("fi,fi->f", normals, camera.camera_to_world[:3, 3] - a) >= 0
    towards_eye = np.where(front[:, None], normals, -normals)
    lambert = AMBIENT + (1 - AMBIENT) * np.clip(towards_eye @ LIGHT, 0, 1)
    return colors * (lambert * np.where(front, 1.0, BACK_SIDE))[:, None]


def _covered_pixels(
    corners_px: np.ndarray, inverse_depths: np.ndarray, camera: Camera
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs (triangle, flat pixel index, 1 / depth) of pixel centres inside triangles, all triangles at once."""
    low = np.maximum(np.ceil(corners_px.min(axis=1) - 0.5), 0).astype(int)
    high = np.minimum(np.floor(corners_px.max(axis=1) - 0.5), [camera.width - 1, camera.height - 1]).astype(int)
    size = np.maximum(high - low + 1, 0)
    count = size.prod(axis=1)
    triangle = np.repeat(np.arange(len(count)), count)
    rank = np.arange(len(triangle)) - np.repeat(np.cumsum(count) - count, count)
    column = low[triangle, 0] + rank % size[triangle, 0]
    row = low[triangle, 1] + rank // size[triangle, 0]

    first, second, third = (corners_px[:, corner] for corner in range(3))
    area = _cross(second - first, third - first)
    flat = np.abs(area) < 1e-12
    # Weights of the second and third corner, and 1 / depth, are linear in the picture: three coefficients a triangle.
    scale = 1 / np.where(flat, 1, area)
    edge_u, edge_v = (third - first) * scale[:, None], (second - first) * scale[:, None]
    dx, dy = column + 0.5 - first[triangle, 0], row + 0.5 - first[triangle, 1]
    u = dx * edge_u[triangle, 1] - dy * edge_u[triangle, 0]
    v = dy * edge_v[triangle, 0] - dx * edge_v[triangle, 1]
    slack = 1e-6
    inside = (u >= -slack) & (v >= -slack) & (u + v <= 1 + slack) & ~flat[triangle]
    triangle, u, v = triangle[inside], u[inside], v[inside]
    steps = inverse_depths[:, 1:] - inverse_depths[:, :1]
    inverse = inverse_depths[triangle, 0] + u * steps[triangle, 0] + v * steps[triangle, 1]
    return triangle, (row[inside] * camera.width + column[inside]), inverse


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def draw_table(size_m: np.ndarray, top_m: float, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Background and table top: picture (h, w, 3) float and depth (h, w), traced ray by ray, so never clipped."""
    rays, eye = camera.rays(), camera.camera_to_world[:3, 3]
    down = rays[..., 2] < -1e-9
    depth = np.where(down, (top_m - eye[2]) / np.where(down, rays[..., 2], -1.0), np.inf)
    with_depth = np.where(np.isfinite(depth), depth, 0.0)
    hit = eye[:2] + with_depth[..., None] * rays[..., :2]
    on_table = down & (depth > NEAR_M) & (np.abs(hit) <= np.asarray(size_m[:2]) / 2).all(axis=-1)
    lambert = AMBIENT + (1 - AMBIENT) * LIGHT[2]
    return np.where(on_table[..., None], TABLE * lambert, BACKGROUND), np.where(on_table, depth, np.inf)


def head_camera(scene: Scene, width: int, height: int) -> Camera:
    """The scene's head camera for a picture of the given size."""
    head = scene.cameras["head"]
    full = Camera(camera_to_world=head.pose, fy_px=head.fy_px, width=head.width, height=head.height)
    return full.resized(width, height)


def render_head_view(
    garment_m: np.ndarray, faces: np.ndarray, scene: Scene, width: int, height: int, color: np.ndarray = GARMENT
) -> np.ndarray:
    """What the head camera sees of table and garment, without the arms: (height, width, 3) u8.

    Args:
        garment_m: (v, 3) world frame.
        faces: (f, 3).
        scene: gives the camera `head` and the table.
        width: pixels.
        height: pixels; the camera's vertical field of view is kept.
        color: (3,) 0 to 255, front of the fabric.
    """
    camera = head_camera(scene, width, height)
    canvas, depth = draw_table(scene.table_size_m, scene.table_top_m - TABLE_DROP_M, camera)
    render(garment_m, faces, color, camera, canvas, depth)
    return np.clip(np.rint(canvas), 0, 255).astype(np.uint8)


def in_view_share(garment_m: np.ndarray, scene: Scene) -> float:
    """Share of the garment (T, v, 3) that lies inside the head camera's picture when least of it does."""
    head = scene.cameras["head"]
    camera = head_camera(scene, head.width, head.height)
    pixel, depth = camera.project(garment_m.reshape(-1, 3).astype(float))
    inside = (depth > NEAR_M) & (pixel >= 0).all(axis=1) & (pixel < [camera.width, camera.height]).all(axis=1)
    return float(inside.reshape(len(garment_m), -1).mean(axis=1).min())
