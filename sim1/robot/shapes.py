"""Triangle meshes of a robot's simple shapes."""

import numpy as np
import trimesh

from sim1.robot.urdf import Link, Shape

type Colored = tuple[np.ndarray, np.ndarray, tuple[float, ...]]
"""Vertices (v, 3) in m, faces (f, 3), colour rgba."""


def link_meshes(link: Link, *, segments: int = 24) -> list[Colored]:
    """Meshes of a link's visual shapes, in the link's frame; cylinders get `segments` sides."""
    return [_mesh(shape, segments) for shape in link.visuals]


def _mesh(shape: Shape, segments: int) -> Colored:
    if shape.kind == "box":
        solid = trimesh.creation.box(extents=shape.size_m)
    elif shape.kind == "cylinder":
        radius, length = shape.size_m
        solid = trimesh.creation.cylinder(radius=radius, height=length, sections=segments)
    else:
        solid = trimesh.creation.icosphere(subdivisions=2, radius=shape.size_m[0])
    vertices = np.asarray(solid.vertices) @ shape.origin[:3, :3].T + shape.origin[:3, 3]
    return vertices, np.asarray(solid.faces), shape.rgba
