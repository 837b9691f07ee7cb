"""The force that one world has and another lacks, along a motion of the first: no springs, no noise, at every vertex."""

from dataclasses import replace

import numpy as np

from sim1.cloth.precise.forces import residual
from sim1.cloth.precise.march import SLIDING_M_S
from sim1.cloth.precise.memory import remember, settle
from sim1.cloth.precise.scene import Scene
from sim1.cloth.precise.world import World, pack

RIG = (
    "lag_s",
    "clock_offset_s",
    "frame_shift_m",
    "frame_turn_rad",
    "compliance_m_n",
    "slip_threshold_n",
    "slip_rate_m_n_s",
)


def cloth_part(model: World, plain: World) -> World:
    """`plain` with all of `model` that acts on the cloth itself; equal to `plain` where only grips, clocks or cameras differ."""
    return replace(model, **{name: getattr(plain, name) for name in RIG})


def lacking_force(scene: Scene, model: World, plain: World, shapes_m: np.ndarray) -> np.ndarray:
    """Force (T, M, 3) [N] near each marker, for its share of the sheet's area; `shapes_m` (T, V, 3) is a motion in `model`.

    What grips differ by is left out: they are stiff, and a difference of places would count as a force.
    """
    return lacking_forces(scene, [model], plain, shapes_m)[0]


def lacking_forces(scene: Scene, models: list[World], plain: World, shapes_m: np.ndarray) -> np.ndarray:
    """Forces (P, T, M, 3) [N] that each of P models has and `plain` lacks, along one and the same motion."""
    net, count = scene.net, len(models) + 1
    cloth = pack(scene.sheet, [*(cloth_part(model, plain) for model in models), plain], scene.clamped, scene.rim)
    stencils, steps = len(net.first) - 1, len(shapes_m)
    curvature, moment, crease = (np.zeros((count, stencils, size)) for size in (3, 3, 6))
    now, nowhere = np.zeros((stencils, 3)), np.zeros((len(net.held), 3))
    free = np.zeros(len(net.held), bool)
    settle(np.repeat(shapes_m[:1], count, axis=0), net, cloth, curvature, moment, crease)
    velocity = np.gradient(shapes_m, scene.step_s, axis=0)
    acceleration = np.gradient(velocity, scene.step_s, axis=0)
    left, found = np.empty((count, *shapes_m.shape[1:])), np.empty((len(models), steps, len(net.marker_node), 3))
    share_m2 = scene.sheet.face_area_m2.sum() / len(net.marker_node)
    for n in range(steps):
        for p in range(count):
            residual(
                shapes_m[n], velocity[n], acceleration[n], SLIDING_M_S, net, cloth, p, curvature[p], moment[p], crease[p],
                nowhere, free, left[p],
            )  # fmt: skip
            remember(shapes_m[n], net, cloth.scalar[p], curvature[p], moment[p], crease[p], now)
        density = (left[-1] - left[:-1]) / scene.sheet.vertex_area_m2[:, None]
        found[:, n] = share_m2 * (density[:, net.marker_node] * net.marker_weight[..., None]).sum(2)
    return found
