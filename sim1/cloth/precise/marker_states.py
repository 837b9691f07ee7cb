"""What the sheet does at its markers along a motion: how it faces, is strained and bent, and how far off it is held."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from sim1.cloth.precise.scene import Scene


@dataclass(frozen=True, kw_only=True)
class MarkerStates:
    """States of the sheet at T steps and M markers, from the stencil that is nearest to each."""

    normal: np.ndarray  # (T, M, 3), unit
    threads: np.ndarray  # (T, M, 2, 3), unit, along u and v
    strain: np.ndarray  # (T, M, 3) of Green: uu, vv, uv
    curvature_1_m: np.ndarray  # (T, M, 3) towards the normal: uu, vv, uv
    grip_m: np.ndarray  # (T, M) over the flat cloth to the nearest held vertex; infinite while nothing is held

    def at(self, steps: np.ndarray) -> "MarkerStates":
        """Those of some steps, (T,) of bool."""
        return MarkerStates(**{name: value[steps] for name, value in vars(self).items()})


def marker_states(scene: Scene, shapes_m: np.ndarray) -> MarkerStates:
    """States at the markers of a scene; `shapes_m` (T, V, 3) is a motion at its steps."""
    net, material = scene.net, scene.sheet.material_m
    points = (material[net.marker_node] * net.marker_weight[..., None]).sum(1)
    nearest = cKDTree(material[net.centre]).query(points)[1]
    slope, second = np.empty((len(shapes_m), len(points), 2, 3)), np.empty((len(shapes_m), len(points), 3, 3))
    for m, c in enumerate(nearest):
        nodes = slice(net.first[c], net.first[c + 1])
        around = shapes_m[:, net.node[nodes]]
        slope[:, m] = net.slope[nodes].T @ around
        second[:, m] = net.second[nodes].T @ around
    across = np.cross(slope[:, :, 0], slope[:, :, 1])
    normal = across / np.linalg.norm(across, axis=-1, keepdims=True)
    square = slope @ np.swapaxes(slope, -1, -2)
    return MarkerStates(
        normal=normal,
        threads=slope / np.linalg.norm(slope, axis=-1, keepdims=True),
        strain=0.5 * np.stack([square[..., 0, 0] - 1.0, square[..., 1, 1] - 1.0, square[..., 0, 1]], axis=-1),
        curvature_1_m=(second * normal[:, :, None]).sum(-1),
        grip_m=_grip_m(scene, points),
    )


def _grip_m(scene: Scene, points: np.ndarray) -> np.ndarray:
    away = np.full((len(scene.time_s), len(points)), np.inf)
    for grip in scene.grips:
        here = cKDTree(scene.sheet.material_m[grip.vertices]).query(points)[0]
        away[grip.active] = np.minimum(away[grip.active], here)
    return away
