"""Blender materials of fabric, table, room and robot. Imported by the worker alone: bpy lives in processes of its own.

What is painted lies in pictures (`sim1.render.images`); the node graphs here put them on, with relief and finish.
"""

from pathlib import Path

import bpy  # noqa: TID253  only the worker's process gets here

from sim1.render.appearance import Color, Fabric, Surface
from sim1.render.looks.colors import linear
from sim1.render.looks.weaves import REPEAT

SCAN_LAYER = "scan"  # UV of the garment's measured texture
FLAT_LAYER = "flat"  # UV over the rectangle that a picture covers
METRE_LAYER = "metres"  # UV in metres on the garment


def rgba(color: Color) -> tuple[float, float, float, float]:
    """SRGB to the linear RGBA that Blender's sockets expect."""
    return (*linear(color).tolist(), 1.0)


class _Graph:
    """A material's node graph, with the few steps that the looks below are made of."""

    def __init__(self, name: str):
        self.material = bpy.data.materials.new(name)
        self.tree = self.material.node_tree
        self.surface = next(node for node in self.tree.nodes if node.type == "BSDF_PRINCIPLED")

    def node(self, kind: str, **inputs):
        node = self.tree.nodes.new(kind)
        for name, value in inputs.items():
            self.set(node.inputs[name.replace("_", " ")], value)
        return node

    def set(self, socket, value) -> None:
        """Link a socket to another one, or give it a value."""
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def finish(self, **inputs) -> bpy.types.Material:
        """Set sockets of the surface and give the material."""
        for name, value in inputs.items():
            self.set(self.surface.inputs[name.replace("_", " ")], value)
        return self.material

    def image(self, image: bpy.types.Image, layer: str, *, extension: str = "EXTEND"):
        """Colour socket of an image on a UV layer; the preview engine shows the material's active image."""
        place = self.node("ShaderNodeUVMap")
        place.uv_map = layer
        node = self.node("ShaderNodeTexImage", Vector=place.outputs["UV"])
        node.image, node.extension = image, extension
        self.tree.nodes.active = node
        return node.outputs["Color"]

    def mix(self, blend: str, factor, a, b):
        node = self.tree.nodes.new("ShaderNodeMix")
        node.data_type, node.blend_type = "RGBA", blend
        # A mix node has sockets of all types under the same names; those of colours are found by their identifiers.
        sockets = {socket.identifier: socket for socket in node.inputs}
        for name, value in (("Factor_Float", factor), ("A_Color", a), ("B_Color", b)):
            self.set(sockets[name], value)
        return next(socket for socket in node.outputs if socket.identifier == "Result_Color")

    def scaled(self, value, factor: float, plus: float):
        node = self.tree.nodes.new("ShaderNodeMath")
        node.operation = "MULTIPLY_ADD"
        for socket, given in zip(node.inputs, (value, factor, plus)):
            self.set(socket, given)
        return node.outputs[0]


def fabric_material(fabric: Fabric, colors: bpy.types.Image, layer: str, weave: bpy.types.Image) -> bpy.types.Material:
    """The garment's material: colours on a UV layer, the weave's relief, shade and weft over them."""
    graph = _Graph("fabric")
    place = graph.node("ShaderNodeUVMap")
    place.uv_map = METRE_LAYER
    scale = 1.0 / (REPEAT * fabric.thread_m)
    threads = graph.node(
        "ShaderNodeMapping", Vector=place.outputs["UV"], Rotation=(0.0, 0.0, -fabric.turn_rad), Scale=(scale,) * 3
    )
    tile = graph.node("ShaderNodeTexImage", Vector=threads.outputs[0])
    tile.image = weave
    height, weft, _ = graph.node("ShaderNodeSeparateColor", Color=tile.outputs["Color"]).outputs
    color = graph.image(colors, layer)
    if fabric.weft > 0.0:
        color = graph.mix("MIX", graph.scaled(weft, fabric.weft, 0.0), color, rgba(fabric.colors[1]))
    if fabric.shade > 0.0:
        # The shade is given in sRGB, where brightness is about the square root of the light.
        bright = graph.scaled(height, fabric.shade, 1.0 - fabric.shade)
        bright = graph.node("ShaderNodeCombineColor", Red=bright, Green=bright, Blue=bright).outputs[0]
        color = graph.mix("MULTIPLY", 1.0, graph.mix("MULTIPLY", 1.0, color, bright), bright)
    if fabric.relief_m > 0.0:
        bump = graph.node("ShaderNodeBump", Height=height, Distance=fabric.relief_m)
        graph.finish(Normal=bump.outputs["Normal"])
    return graph.finish(
        Base_Color=color,
        Roughness=fabric.roughness,
        Sheen_Weight=fabric.sheen,
        Specular_IOR_Level=0.2,  # cloth has little mirror reflection
    )


def scanned_image(texture: Path) -> bpy.types.Image:
    """The garment's measured texture."""
    return bpy.data.images.load(str(texture), check_existing=True)


def surface_material(name: str, surface: Surface, image: bpy.types.Image) -> bpy.types.Material:
    """A table top's or a floor's material."""
    graph = _Graph(name)
    return graph.finish(
        Base_Color=graph.image(image, FLAT_LAYER),
        Roughness=surface.roughness,
        Metallic=surface.metallic,
        Coat_Weight=surface.coat,
    )


def plain_material(name: str, color: Color, *, roughness: float) -> bpy.types.Material:
    """One colour, for robot, furniture and walls."""
    graph = _Graph(name)
    graph.material.diffuse_color = rgba(color)  # what the preview engine shows
    return graph.finish(Base_Color=rgba(color), Roughness=roughness)
