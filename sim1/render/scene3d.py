"""The Blender scene of one garment's episodes. Imported by the worker alone: bpy lives in its own process.

The scene is built once. Between frames only the garment's vertices, the robot's transforms and the camera change,
between appearances materials and lights as well.
"""

from pathlib import Path
from typing import Any

import bpy  # noqa: TID253  only the worker's process gets here
import numpy as np
from mathutils import Matrix, Vector

from sim1.render import materials
from sim1.render.appearance import Appearance, Lamp

SENSOR_MM = 24.0  # any height will do: only its ratio to the focal length shows


class RenderScene:
    """Garment, table, floor, robot, lights and a camera.

    Args:
        arrays: `faces` (f, 3), `uv` (f, 3, 2), `pattern_m` (v, 2), `table_vertices`, `table_faces`, and for part p of the
            robot `part_p_vertices`, `part_p_faces`.
        part_colors: sRGB colour of every part of the robot.
        texture: the garment's measured texture.
        settings: width, height, samples, denoise, threads, device, seed.
    """

    def __init__(self, *, arrays: dict[str, np.ndarray], part_colors: list, texture: Path, settings: dict[str, Any]):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self._scene = bpy.context.scene
        self._texture = texture
        self._set_up_cycles(settings)
        self._garment = self._add_mesh("garment", np.zeros((len(arrays["pattern_m"]), 3)), arrays["faces"], smooth=True)
        layer = self._garment.data.uv_layers.new(name=materials.UV_LAYER)
        layer.data.foreach_set("uv", arrays["uv"].astype(np.float32).ravel())
        pattern = self._garment.data.attributes.new(materials.PATTERN_ATTRIBUTE, "FLOAT_VECTOR", "POINT")
        flat = np.zeros((len(arrays["pattern_m"]), 3), np.float32)
        flat[:, :2] = arrays["pattern_m"]
        pattern.data.foreach_set("vector", flat.ravel())
        self._table = self._add_mesh("table", arrays["table_vertices"], arrays["table_faces"])
        self._floor = self._add_mesh("floor", *_floor(arrays["table_vertices"]))
        self._parts = []
        for index, color in enumerate(part_colors):
            name = f"part_{index}"
            part = self._add_mesh(name, arrays[f"{name}_vertices"], arrays[f"{name}_faces"])
            part.data.materials.append(materials.plain_material(name, color, roughness=0.45))
            self._parts.append(part)
        self._camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        self._scene.collection.objects.link(self._camera)
        self._scene.camera = self._camera

    def set_appearance(self, appearance: Appearance) -> None:
        """Replace materials and lights."""
        for item, material in (
            (self._garment, materials.fabric_material(appearance.fabric, self._texture)),
            (self._table, materials.table_material(appearance.table)),
            (self._floor, materials.plain_material("floor", appearance.floor, roughness=0.9)),
        ):
            item.data.materials.clear()
            item.data.materials.append(material)
        for item in [item for item in bpy.data.objects if item.type == "LIGHT"]:
            bpy.data.lights.remove(item.data)
        for lamp in appearance.lamps:
            self._add_lamp(lamp)
        world = bpy.data.worlds.get("sky") or bpy.data.worlds.new("sky")
        background = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
        background.inputs["Color"].default_value = materials.linear(appearance.sky)
        background.inputs["Strength"].default_value = appearance.sky_strength
        self._scene.world = world

    def set_frame(self, *, garment_m: np.ndarray, parts: np.ndarray) -> None:
        """Move the garment's vertices (v, 3) and the robot's parts (p, 4, 4), world frame."""
        self._garment.data.vertices.foreach_set("co", np.ascontiguousarray(garment_m, np.float32).ravel())
        self._garment.data.update()
        for item, pose in zip(self._parts, parts, strict=True):
            item.matrix_world = Matrix(pose.tolist())

    def render(self, path: Path, *, camera_to_world: np.ndarray, fy_over_height: float) -> None:
        """Render what a pinhole camera sees to a PNG file at exactly `path`."""
        self._camera.matrix_world = Matrix(camera_to_world.tolist())
        lens = self._camera.data
        lens.sensor_fit, lens.sensor_height, lens.lens = "VERTICAL", SENSOR_MM, fy_over_height * SENSOR_MM
        lens.clip_start, lens.clip_end = 0.01, 50.0
        self._scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)

    def _add_mesh(self, name: str, vertices: np.ndarray, faces: np.ndarray, smooth: bool = False) -> bpy.types.Object:
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(np.asarray(vertices, float).tolist(), [], np.asarray(faces, int).tolist())
        if smooth:
            mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
        mesh.update()
        item = bpy.data.objects.new(name, mesh)
        self._scene.collection.objects.link(item)
        return item

    def _add_lamp(self, lamp: Lamp) -> None:
        light = bpy.data.lights.new("lamp", "AREA")
        light.energy, light.size, light.color = lamp.power_w, lamp.side_m, materials.linear(lamp.color)[:3]
        item = bpy.data.objects.new("lamp", light)
        item.location = lamp.position_m
        item.rotation_euler = (-Vector(lamp.position_m)).to_track_quat("-Z", "Y").to_euler()
        self._scene.collection.objects.link(item)

    def _set_up_cycles(self, settings: dict[str, Any]) -> None:
        render, cycles = self._scene.render, self._scene.cycles
        render.engine = "CYCLES"
        render.resolution_x, render.resolution_y, render.resolution_percentage = (
            settings["width"],
            settings["height"],
            100,
        )
        render.use_persistent_data = True  # keeps what did not change between frames
        render.threads_mode, render.threads = "FIXED", settings["threads"]
        render.use_file_extension = False
        image = render.image_settings
        image.file_format, image.color_mode, image.color_depth, image.compression = "PNG", "RGB", "8", 50
        for name in [name for name in dir(render) if name.startswith("use_stamp")]:
            setattr(render, name, False)  # dates and host names would end up in the PNG file
        cycles.samples, cycles.use_adaptive_sampling = settings["samples"], False
        cycles.use_denoising = settings["denoise"]
        cycles.seed = settings["seed"]
        cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 4, 2, 2
        cycles.caustics_reflective = cycles.caustics_refractive = False
        cycles.sample_clamp_indirect = 5.0  # few samples: no fireflies
        cycles.device = _choose_device(settings["device"])


def _choose_device(wanted: str) -> str:
    """GPU where one is wanted or, with "auto", found; "cpu" never looks."""
    if wanted == "cpu":
        return "CPU"
    preferences = bpy.context.preferences.addons["cycles"].preferences
    for backend in ("OPTIX", "CUDA", "HIP", "ONEAPI", "METAL"):
        try:
            preferences.compute_device_type = backend
        except TypeError:
            continue  # this build of Blender does not know it
        preferences.get_devices()
        devices = [device for device in preferences.devices if device.type == backend]
        if devices:
            for device in preferences.devices:
                device.use = device.type == backend
            return "GPU"
    if wanted == "gpu":
        raise RuntimeError("device is 'gpu', and Cycles finds none; set it to 'auto' or 'cpu'")
    return "CPU"


def _floor(table_vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    height = float(table_vertices[:, 2].min()) - 0.7  # m below the table top's plate, unless it has legs of its own
    side = 6.0
    corners = [[-side, -side, height], [side, -side, height], [side, side, height], [-side, side, height]]
    return np.array(corners), np.array([[0, 1, 2, 3]])
