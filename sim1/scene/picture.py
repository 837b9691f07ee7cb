"""Pictures of a scene: drawn from a camera, and the map of what the arms reach."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from sim1.picture_file import save_figure
from sim1.robot.planar import PlanarArm
from sim1.scene.description import Camera, Scene
from sim1.scene.environment import look_at
from sim1.scene.parts import Part
from sim1.scene.reach import over_table, reach_of

NEAR_M = 0.05
LIGHT = np.array([-0.3, 0.35, 0.88])
LIMITS_DEG = (0, 2.5, 22.5, 47.5, 90)  # classes of leaning on the map
CLASSES = ("straight down", "leaning up to 20°", "up to 45°", "more")
COLORS = ("#1b7837", "#7fbf7b", "#dcec8a", "#f1c27d")


def draw_scene(path: Path, scene: Scene, parts: Sequence[Part], title: str) -> None:
    """Overview from the left front, and the head camera's view."""
    overview = Camera(
        width=640, height=480, fy_px=640.0,
        pose=look_at(np.array([1.15, 1.05, 0.95]), np.array([-0.02, 0.0, 0.03]), np.array([0.0, 0.0, 1.0])),
    )  # fmt: skip
    figure = Figure(figsize=(10.5, 4.4), dpi=90, layout="constrained")
    figure.suptitle(title)
    views = (("overview from the left front", overview), ("head camera, arms at home", scene.cameras["head"]))
    for place, (name, camera) in enumerate(views, 1):
        axes = figure.add_subplot(1, 2, place)
        axes.add_collection(_project(parts, camera))
        axes.set(title=name, xlim=(0, camera.width), ylim=(camera.height, 0), aspect="equal", xlabel="px", ylabel="px")
    save_figure(figure, path)


def draw_reach(path: Path, scene: Scene, arm: PlanarArm, garment_m: np.ndarray, height_m: float) -> None:
    """Map of the table: how much the tool must lean for each arm, and for the better one, to get there."""
    x, y, points = over_table(scene.table_size_m, scene.table_top_m + height_m, 0.01)
    reach = reach_of(points, scene, arm)
    maps = {"left arm": reach.tilt_deg["left"], "right arm": reach.tilt_deg["right"], "either arm": reach.either()}
    figure = Figure(figsize=(11.5, 3.6), dpi=90, layout="constrained")
    figure.suptitle(f"Reach {1000 * height_m:.0f} mm above the table, by how much the tool leans outward")
    norm = BoundaryNorm(LIMITS_DEG, len(COLORS))
    for place, (name, tilt) in enumerate(maps.items(), 1):
        axes = figure.add_subplot(1, 3, place)
        shown = np.ma.masked_invalid(tilt.reshape(len(x), len(y)))
        drawn = axes.pcolormesh(y, x, shown, norm=norm, cmap=ListedColormap(COLORS), shading="nearest")
        axes.scatter(garment_m[:, 1], garment_m[:, 0], s=0.5, c="#333333", linewidths=0, label="garment")
        for pose in scene.base_to_world.values():
            axes.plot(pose[1, 3], pose[0, 3], "k^", markersize=7)
        axes.set(title=name, aspect="equal", xlabel="y (m)", ylabel="x (m)", xlim=(y[-1], y[0]), facecolor="#dddddd")
    middles = [(low + high) / 2 for low, high in pairwise(LIMITS_DEG)]
    bar = figure.colorbar(drawn, ax=figure.axes, ticks=middles)
    bar.ax.set_yticklabels(CLASSES)
    bar.ax.set_title("grey: none", fontsize="small")
    save_figure(figure, path)


def _project(parts: Sequence[Part], camera: Camera) -> PolyCollection:
    """Triangles of all parts in pixels, shaded, far ones first; the table below everything."""
    world_to_camera = np.linalg.inv(camera.pose)
    triangles, colors, order = [], [], []
    for part in parts:
        for vertices, faces, rgb in part.meshes:
            world = vertices @ part.pose[:3, :3].T + part.pose[:3, 3]
            corners = world[faces]
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
            seen = corners @ world_to_camera[:3, :3].T + world_to_camera[:3, 3]
            depth = -seen[..., 2]
            inside = depth.min(axis=1) > NEAR_M
            if part.path != "garment":  # closed bodies: their far sides are hidden
                inside &= ((camera.pose[:3, 3] - corners.mean(axis=1)) * normals).sum(axis=1) > 0
            flat = camera.fy_px * seen[..., :2] / np.maximum(depth, NEAR_M)[..., None]
            pixels = np.array([camera.width / 2, camera.height / 2]) + flat * [1, -1]
            shade = 0.45 + 0.55 * np.abs(normals @ LIGHT)
            triangles.append(pixels[inside])
            colors.append((np.broadcast_to(rgb, (len(faces), 3)) * shade[:, None])[inside])
            order.append(depth.mean(axis=1)[inside] + (100.0 if part.path == "table" else 0.0))
    sequence = np.argsort(-np.concatenate(order), kind="stable")
    fill = np.clip(np.concatenate(colors), 0, 1)[sequence]
    return PolyCollection(np.concatenate(triangles)[sequence], facecolors=fill, edgecolors=fill, linewidths=0.5)
