"""A room about the table in Blender: floor, walls, furniture, sky and lamps. Imported by the worker alone."""

from collections.abc import Callable

import bpy  # noqa: TID253  only the worker's process gets here
import numpy as np
from mathutils import Vector

from sim1.render import images, materials
from sim1.render.appearance import Lamp, Room, Surface
from sim1.render.looks.colors import light_color
from sim1.render.looks.lamps import lamp_power_w
from sim1.render.looks.room_meshes import room_meshes

QUAD = np.array([[0, 1, 2, 3]])
MAP_POINTS = 256  # of the table by which Cycles finds the sky's bright places: a sky has 128 rows

type SurfaceMaker = Callable[[Surface, np.ndarray], bpy.types.Material]
"""Material of a surface that covers a rectangle with the given corners (n, 3)."""


class Surroundings:
    """Everything that stands about the table in one room, until it is removed.

    Args:
        room: as drawn.
        table_m: (v, 3) vertices of the table.
        surface: makes the floor's material.
    """

    def __init__(self, room: Room, table_m: np.ndarray, surface: SurfaceMaker):
        meshes = room_meshes(room, table_m)
        floor = add_mesh("floor", meshes.floor, QUAD)
        flat = meshes.floor_flat_m
        uv = (flat - flat.min(axis=0)) / np.ptp(flat, axis=0)
        floor.data.uv_layers.new(name=materials.FLAT_LAYER).uv.foreach_set("vector", uv.astype(np.float32).ravel())
        floor.data.materials.append(surface(room.floor, flat))
        self._items = [floor]
        paint = materials.plain_material("walls", room.walls, roughness=0.9)
        for number, corners in enumerate(meshes.walls):
            wall = add_mesh(f"wall_{number}", corners, QUAD)
            wall.data.materials.append(paint)
            # Walls are seen and nothing else: the sky holds the light that they and their windows send, and must not be shut out.
            wall.visible_diffuse = wall.visible_glossy = wall.visible_shadow = False
            self._items.append(wall)
        for part in meshes.furniture:
            color = room.furniture_colors[part.color]
            item = add_mesh(f"furniture_{part.color}", part.vertices_m, part.faces)
            item.data.materials.append(materials.plain_material(f"furniture_{part.color}", color, roughness=0.6))
            self._items.append(item)
        self._items += [_add_lamp(lamp) for lamp in room.lamps]
        self._world = _add_sky(room)

    def remove(self) -> None:
        """Take it all out of Blender's memory, but for materials and images."""
        for item in self._items:
            data = item.data
            (bpy.data.lights if item.type == "LIGHT" else bpy.data.meshes).remove(data)
        bpy.data.worlds.remove(self._world)


def add_mesh(name: str, vertices: np.ndarray, faces: np.ndarray, smooth: bool = False) -> bpy.types.Object:
    """Add a mesh of triangles or quadrangles to the scene."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(vertices, float).tolist(), [], np.asarray(faces, int).tolist())
    if smooth:
        mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.update()
    return _link(name, mesh)


def _link(name: str, data: bpy.types.ID) -> bpy.types.Object:
    item = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(item)
    return item


def _add_lamp(lamp: Lamp) -> bpy.types.Object:
    light = bpy.data.lights.new("lamp", "AREA")
    light.energy, light.size, light.color = lamp_power_w(lamp), lamp.side_m, light_color(lamp.color).tolist()
    position = Vector(lamp.position_m)
    item = _link("lamp", light)
    item.location = position
    item.rotation_euler = (-position).to_track_quat("-Z", "Y").to_euler()
    return item


def _add_sky(room: Room) -> bpy.types.World:
    world = bpy.data.worlds.new("sky")
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    picture = tree.nodes.new("ShaderNodeTexEnvironment")
    picture.image = images.sky_image(room)
    tree.links.new(picture.outputs["Color"], background.inputs["Color"])
    world.cycles.sampling_method, world.cycles.sample_map_resolution = "MANUAL", MAP_POINTS
    bpy.context.scene.world = world
    return world
