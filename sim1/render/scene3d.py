"""The Blender scene of one garment's episodes. Imported by the worker alone: bpy lives in processes of its own.

The scene is built once. Between frames only the garment's vertices, the robot's transforms and the camera change, between
appearances materials, light and everything that stands about the table as well.
"""

from pathlib import Path
from typing import Any

import bpy  # noqa: TID253  only the worker's process gets here
import numpy as np
from mathutils import Matrix

from sim1.render import images, materials
from sim1.render.appearance import SCANNED, Appearance, Fabric, Surface
from sim1.render.engines import set_up_engine
from sim1.render.surroundings import Surroundings, add_mesh

SENSOR_MM = 24.0  # any height will do: only its ratio to the focal length shows


class RenderScene:
    """Garment, table, robot, what surrounds them, and a camera.

    Args:
        arrays: `faces` (f, 3), `uv` (f, 3, 2), `pattern_m` (v, 2), `table_vertices`, `table_faces`, and for part p of the
            robot `part_p_vertices`, `part_p_faces`.
        part_colors: sRGB colour of every part of the robot.
        texture: the garment's measured texture.
        settings: see `sim1.render.engines.set_up_engine`.

    Attributes:
        device: what renders: "cpu", "gpu" or "opengl".
    """

    def __init__(self, *, arrays: dict[str, np.ndarray], part_colors: list, texture: Path, settings: dict[str, Any]):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self._scene = bpy.context.scene
        self._texture = texture
        self.device = set_up_engine(self._scene, settings)
        self._points = images.picture_points(settings["width"])
        self._flat_m, self._table_m = arrays["pattern_m"], arrays["table_vertices"]
        self._garment = add_mesh("garment", np.zeros((len(self._flat_m), 3)), arrays["faces"], smooth=True)
        corners_m = self._flat_m[arrays["faces"]]
        _lay_out(self._garment, materials.SCAN_LAYER, arrays["uv"])
        _lay_out(self._garment, materials.METRE_LAYER, corners_m)
        _lay_out(self._garment, materials.FLAT_LAYER, _within(corners_m, self._flat_m))
        self._table = add_mesh("table", self._table_m, arrays["table_faces"])
        _lay_out(self._table, materials.FLAT_LAYER, _within(self._table_m[arrays["table_faces"]], self._table_m))
        self._parts = []
        for index, color in enumerate(part_colors):
            name = f"part_{index}"
            part = add_mesh(name, arrays[f"{name}_vertices"], arrays[f"{name}_faces"])
            part.data.materials.append(materials.plain_material(name, color, roughness=0.45))
            self._parts.append(part)
        self._camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        self._scene.collection.objects.link(self._camera)
        self._scene.camera = self._camera
        self._lasting = {id_.name for kind in (bpy.data.materials, bpy.data.images) for id_ in kind}
        self._surroundings: Surroundings | None = None

    def set_appearance(self, appearance: Appearance) -> None:
        """Replace materials, light and surroundings."""
        if self._surroundings is not None:
            self._surroundings.remove()
        for item in (self._garment, self._table):
            item.data.materials.clear()
        for kind in (bpy.data.materials, bpy.data.images):
            for id_ in [id_ for id_ in kind if id_.name not in self._lasting]:
                kind.remove(id_)
        self._garment.data.materials.append(self._fabric(appearance.fabric))
        self._table.data.materials.append(self._surface("table", appearance.table.surface, self._table_m))
        self._surroundings = Surroundings(
            appearance.room, self._table_m, lambda surface, corners_m: self._surface("floor", surface, corners_m)
        )

    def set_frame(self, *, garment_m: np.ndarray, parts: np.ndarray) -> None:
        """Move the garment's vertices (v, 3) and the robot's parts (p, 4, 4), world frame."""
        self._garment.data.vertices.foreach_set("co", np.ascontiguousarray(garment_m, np.float32).ravel())
        self._garment.data.update()
        for item, pose in zip(self._parts, parts, strict=True):
            item.matrix_world = Matrix(pose.tolist())

    def render(self, path: Path, *, camera_to_world: np.ndarray, fy_over_height: float, seed: int) -> None:
        """Render what a pinhole camera sees, with noise of `seed`, to a PNG file at exactly `path`."""
        self._scene.cycles.seed = seed
        self._camera.matrix_world = Matrix(camera_to_world.tolist())
        lens = self._camera.data
        lens.sensor_fit, lens.sensor_height, lens.lens = "VERTICAL", SENSOR_MM, fy_over_height * SENSOR_MM
        lens.clip_start, lens.clip_end = 0.01, 50.0
        self._scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)

    def _fabric(self, fabric: Fabric) -> bpy.types.Material:
        if fabric.name == SCANNED:
            colors, layer = materials.scanned_image(self._texture), materials.SCAN_LAYER
        else:
            low, high = self._flat_m.min(axis=0), self._flat_m.max(axis=0)
            colors, layer = images.fabric_image(fabric, low, high, self._points), materials.FLAT_LAYER
        self._garment.data.uv_layers[layer].active_render = True  # the preview engine knows one layer
        self._garment.data.uv_layers[layer].active = True
        return materials.fabric_material(fabric, colors, layer, images.weave_image(fabric))

    def _surface(self, name: str, surface: Surface, corners_m: np.ndarray) -> bpy.types.Material:
        low, high = corners_m[:, :2].min(axis=0), corners_m[:, :2].max(axis=0)
        return materials.surface_material(name, surface, images.surface_image(name, surface, low, high, self._points))


def _lay_out(item: bpy.types.Object, layer: str, uv: np.ndarray) -> None:
    """Give the mesh a UV layer: (f, 3, 2), a place for every corner of every face."""
    item.data.uv_layers.new(name=layer).uv.foreach_set("vector", uv.astype(np.float32).ravel())


def _within(corners_m: np.ndarray, vertices_m: np.ndarray) -> np.ndarray:
    """Corners (f, 3, 2 or more) as shares of the rectangle around the vertices in the first two axes."""
    low, high = vertices_m[:, :2].min(axis=0), vertices_m[:, :2].max(axis=0)
    return (corners_m[..., :2] - low) / np.maximum(high - low, 1e-3)
