"""Builds the simulation mesh of a garment from its scan: separation, normals, Poisson, openings, remeshing, rest shape."""

from dataclasses import dataclass

import numpy as np

from sim1.progress import report
from sim1.scan.cloud import Cloud, Scan, Shape
from sim1.scan.fit import fitted
from sim1.scan.normals import oriented_normals
from sim1.scan.poisson import cut_open, poisson
from sim1.scan.remesh import area_m2, clean, remesh
from sim1.scan.removal import Separation, separate
from sim1.scan.rest import Rest, rest_shape
from sim1.scan.sliver import without_slivers
from sim1.stage import BadInput

_STEPS = (
    "separating the garment from its support",
    "orienting normals",
    "Poisson reconstruction",
    "openings",
    "remeshing",
    "rest shape",
)

_EDGE_SPACINGS = 2.0  # cut here beyond the outermost points, where no random gap bites in; the rim is then set back


@dataclass(frozen=True, kw_only=True)
class Built:
    """The mesh and what it was made of."""

    separation: Separation
    cloud: Cloud  # the garment's points
    normals: np.ndarray  # (n, 3) outward
    orientation: dict[str, float]
    gaps_m: list[float]  # rims of all gaps of the scan, longest first
    surface: Shape  # before remeshing
    mesh: Shape  # for the simulation
    edge_m: float  # edge length asked of the remeshing
    rest: Rest


def build(
    scan: Scan,
    *,
    openings: int,
    edge_m: float,
    vertex_count: int,
    cell_m: float,
    gap_spacings: float,
    taubin_steps: int,
    angle_rad: float,
) -> Built:
    """Run all steps.

    Raises:
        BadInput: no garment is left beside the support, or the surface has fewer gaps than the garment has openings.
    """
    from scipy.spatial import cKDTree

    report(0, len(_STEPS), _STEPS[0])
    separation = separate(scan.cloud, scan.support, scan.mask)
    cloud = scan.cloud.only(separation.garment)
    if len(cloud) < 0.05 * len(scan.cloud) or len(cloud) < 100:
        raise BadInput(
            f"only {len(cloud)} of {len(scan.cloud)} points are not taken for the support; check that support.ply"
            " stands within a few centimetres of its place in the scan, or give a mask.npz"
        )
    report(1, len(_STEPS), _STEPS[1])
    points = cloud.points_m.astype(float)
    normals, orientation = oriented_normals(points, cloud.normals, cloud.view, scan.scanner_to_world)
    report(2, len(_STEPS), _STEPS[2])
    spacing = float(np.median(cKDTree(points).query(points, k=5)[0][:, 4]))
    closed = poisson(points, normals, cell_m)
    report(3, len(_STEPS), _STEPS[3])
    cut, gaps = cut_open(closed, points, openings, gap_spacings * spacing, _EDGE_SPACINGS * spacing)
    surface = clean(cut, points, spacing, taubin_steps)
    report(4, len(_STEPS), _STEPS[4])
    area = area_m2(surface.vertices_m, surface.faces)
    # An even mesh of v vertices has about 2 v equilateral triangles.
    edge = max(edge_m, float(np.sqrt(area / (2 * vertex_count * 0.433))))
    mesh = fitted(without_slivers(remesh(surface, edge), surface, angle_rad), surface, 0.95 * angle_rad)
    mesh = Shape(vertices_m=mesh.vertices_m.astype(np.float32), faces=mesh.faces)
    report(5, len(_STEPS), _STEPS[5])
    rest = rest_shape(mesh.vertices_m.astype(float), mesh.faces)
    report(6, len(_STEPS))
    return Built(
        separation=separation,
        cloud=cloud,
        normals=normals,
        orientation=orientation,
        gaps_m=gaps,
        surface=surface,
        mesh=mesh,
        edge_m=edge,
        rest=rest,
    )
