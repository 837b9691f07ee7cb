"""Procedural Blender materials of fabric, table and robot. Imported by the worker alone: bpy lives in its own process.

Patterns are functions of metres on the garment, not of its UV chart, so that they have the size that the scan has.
"""

import math
from pathlib import Path

import bpy  # noqa: TID253  only the worker's process gets here

from sim1.render.appearance import Color, Fabric, Table

PATTERN_ATTRIBUTE = "pattern_m"
UV_LAYER = "scan"


def linear(color: Color) -> tuple[float, float, float, float]:
    """SRGB to the linear RGBA that Blender's sockets expect."""
    return (*(c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in color), 1.0)


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

    def math(self, operation: str, *values):
        node = self.tree.nodes.new("ShaderNodeMath")
        node.operation = operation
        for socket, value in zip(node.inputs, values):
            self.set(socket, value)
        return node.outputs[0]

    def ramp(self, factor, *stops: tuple[float, Color], constant: bool = False):
        node = self.tree.nodes.new("ShaderNodeValToRGB")
        node.color_ramp.interpolation = "CONSTANT" if constant else "LINEAR"
        while len(node.color_ramp.elements) < len(stops):
            node.color_ramp.elements.new(0.5)
        for element, (position, color) in zip(node.color_ramp.elements, stops):
            element.position, element.color = position, linear(color)
        self.set(node.inputs[0], factor)
        return node.outputs["Color"]


def fabric_material(fabric: Fabric, texture: Path) -> bpy.types.Material:
    """The garment's material: measured texture or pattern, with roughness, sheen and the weave as bump."""
    graph = _Graph("fabric")
    if fabric.kind == "scanned":
        color = _scanned(graph, texture)
    else:
        color = _pattern(graph, fabric)
    graph.set(graph.surface.inputs["Base Color"], color)
    graph.set(graph.surface.inputs["Roughness"], fabric.roughness)
    graph.set(graph.surface.inputs["Sheen Weight"], fabric.sheen)
    graph.set(graph.surface.inputs["Specular IOR Level"], 0.2)  # cloth has little mirror reflection
    if fabric.bump_m > 0.0:
        place = graph.node("ShaderNodeAttribute")
        place.attribute_name = PATTERN_ATTRIBUTE
        weave = graph.node("ShaderNodeTexNoise", Vector=place.outputs["Vector"], Scale=1.0 / 0.004, Detail=1.0)
        bump = graph.node("ShaderNodeBump", Height=weave.outputs[0], Distance=fabric.bump_m)
        graph.set(graph.surface.inputs["Normal"], bump.outputs["Normal"])
    return graph.material


def _scanned(graph: _Graph, texture: Path):
    uv = graph.node("ShaderNodeUVMap")
    uv.uv_map = UV_LAYER
    image = graph.node("ShaderNodeTexImage", Vector=uv.outputs["UV"])
    image.image = bpy.data.images.load(str(texture), check_existing=True)
    return image.outputs["Color"]


def _pattern(graph: _Graph, fabric: Fabric):
    """Colour socket of a woven or printed pattern; periods in metres on the garment."""
    if fabric.kind == "plain":
        return linear(fabric.base)
    place = graph.node("ShaderNodeAttribute")
    place.attribute_name = PATTERN_ATTRIBUTE
    turned = graph.node("ShaderNodeVectorRotate", Vector=place.outputs["Vector"], Angle=fabric.angle_rad)
    axes = graph.node("ShaderNodeSeparateXYZ", Vector=turned.outputs[0])
    u, v = (graph.math("FRACT", graph.math("DIVIDE", axes.outputs[axis], fabric.period_m)) for axis in ("X", "Y"))
    if fabric.kind == "stripes":
        return graph.ramp(u, (0.0, fabric.base), (0.5, fabric.accent), constant=True)
    if fabric.kind == "checks":  # gingham: warp and weft of two colours each
        threads = graph.math("ADD", graph.math("GREATER_THAN", u, 0.5), graph.math("GREATER_THAN", v, 0.5))
        return graph.ramp(graph.math("MULTIPLY", threads, 0.5), (0.0, fabric.base), (1.0, fabric.accent))
    across, along = (graph.math("SUBTRACT", axis, 0.5) for axis in (u, v))
    squares = (graph.math("MULTIPLY", axis, axis) for axis in (across, along))
    radius = graph.math("SQRT", graph.math("ADD", *squares))
    # Radius 0.25 of the period covers 20 % of the cloth.
    return graph.ramp(radius, (0.0, fabric.accent), (math.sqrt(0.2 / math.pi), fabric.base), constant=True)


def table_material(table: Table) -> bpy.types.Material:
    """Wood with grain along x, marble with veins, or one colour."""
    graph = _Graph("table")
    color = linear(table.base)
    if table.kind != "plain":
        place = graph.node("ShaderNodeTexCoord").outputs["Object"]
        stretch = (0.1, 1.0, 1.0) if table.kind == "wood" else (1.0, 1.0, 1.0)
        mapping = graph.node("ShaderNodeMapping", Vector=place, Scale=stretch)
        noise = graph.node("ShaderNodeTexNoise", Vector=mapping.outputs[0], Scale=1.0 / table.grain_m, Detail=4.0)
        noise.inputs["Distortion"].default_value = 0.5 if table.kind == "wood" else 2.0
        if table.kind == "wood":
            color = graph.ramp(noise.outputs[0], (0.3, table.accent), (0.6, table.base))
        else:
            color = graph.ramp(noise.outputs[0], (0.42, table.base), (0.5, table.accent), (0.58, table.base))
    graph.set(graph.surface.inputs["Base Color"], color)
    graph.set(graph.surface.inputs["Roughness"], table.roughness)
    return graph.material


def plain_material(name: str, color: Color, *, roughness: float, metallic: float = 0.0) -> bpy.types.Material:
    """One colour, for floor and robot."""
    graph = _Graph(name)
    for socket, value in {"Base Color": linear(color), "Roughness": roughness, "Metallic": metallic}.items():
        graph.set(graph.surface.inputs[socket], value)
    return graph.material
