"""The search for layers of the cloth that are near each other, run when the last one no longer suffices."""

from typing import Any

import numpy as np
import warp as wp

from sim1.cloth.avbd import layers
from sim1.cloth.avbd.buffers import packed
from sim1.cloth.avbd.parameters import SelfContact
from sim1.cloth.avbd.sheet import Sheet


class LayerSearch:
    """Trees over triangles and edges, one group a world, so that worlds that lie in the same place do not meet."""

    def __init__(self, model: Any, sheet: Sheet, settings: SelfContact) -> None:
        self._sheet, self._count = sheet, model.particle_count
        self._packed = packed(sheet, Sheet)
        self._rest = wp.clone(model.particle_q)
        self._due = wp.ones(1, dtype=wp.int32)
        world = np.maximum(model.particle_world.numpy(), 0).astype(np.int32)
        self._world = wp.array(world, dtype=wp.int32)
        self._corners = (sheet.triangle.numpy(), sheet.edge.numpy())
        self._boxes = [
            wp.array(box, dtype=wp.vec3) for corners in self._corners for box in _boxes(model.particle_q, corners)
        ]
        self._trees = [
            wp.Bvh(low, high, groups=wp.array(world[corners[:, 0]], dtype=wp.int32))
            for low, high, corners in zip(self._boxes[::2], self._boxes[1::2], self._corners)
        ]
        numbers = layers.LayerNumbers()
        numbers.radius, numbers.rest_exclusion = settings.radius_m, settings.rest_exclusion_m
        numbers.stiffness, numbers.damping = settings.stiffness_n_m, settings.damping_n_s_m
        numbers.friction = settings.friction
        self._numbers = numbers

    def reset(self, positions: wp.array) -> None:
        """Trees of a cloth that is put there: the order in which pairs are found must not depend on what was before."""
        fresh = [box for corners in self._corners for box in _boxes(positions, corners)]
        for box, values in zip(self._boxes, fresh):
            box.assign(values)
        self.rebuild()

    def rebuild(self) -> None:
        """Build the trees anew; refitting alone makes them slow as the cloth folds."""
        for tree in self._trees:
            tree.rebuild()

    def run(self, now: wp.array, guard: wp.array, touches: wp.array, dt: float) -> None:
        """Search around the start of the step if it is due; else leave the records as they are."""
        sheet, due = self._sheet, self._due
        wp.launch(layers.decide_search, dim=self._count, inputs=[now, guard, due])
        wp.launch(
            layers.begin_search,
            dim=max(self._count, len(sheet.triangle), len(sheet.edge)),
            inputs=[now, due, guard, touches, sheet.triangle, sheet.edge, *self._boxes, dt],
        )
        for tree in self._trees:
            tree.refit()
        shared = [self._world, self._packed, self._rest, now, self._numbers, guard, touches, dt]
        triangles, edges = self._trees
        wp.launch(layers.find_vertex_triangle, dim=self._count, inputs=[due, triangles.id, *shared])
        wp.launch(layers.find_edge_edge, dim=len(sheet.edge), inputs=[due, edges.id, *shared])
        due.zero_()


def _boxes(positions: wp.array, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    points = positions.numpy()[corners]
    return points.min(axis=1), points.max(axis=1)
