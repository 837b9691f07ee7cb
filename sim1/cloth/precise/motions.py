"""Motions that were simulated before, and what they foretell of a similar one.

Newton's method is slow far from the answer: a sheet is stiff in its plane and limp out of it. Twins tell how a motion changes with
the world; a world near one that was simulated starts a step or two from its answer.
"""

from dataclasses import dataclass, fields

import numpy as np

from sim1.cloth.precise.scene import Scene
from sim1.cloth.precise.world import World

KEPT = 3  # motions per recording and mesh
FARTHEST_M = 0.02  # leads are straight lines: further than this they lead nowhere
NOT_NUMBERS = ("table_z_m",)


@dataclass
class Motion:
    """A simulated motion with the leads of its twins, or of a neighbour's."""

    world: World
    shapes_m: np.ndarray  # (T, V, 3)
    origin: World  # from which the twins differ
    twins: list[World]
    leads_m: list[np.ndarray]  # (T, V, 3) each


class Motions:
    """The last few motions of one recording on one mesh."""

    def __init__(self) -> None:
        self._kept: list[Motion] = []

    def guess(self, world: World) -> np.ndarray | None:
        """Shapes (T, V, 3) as the nearest motion and its twins foretell them; None: nothing is known."""
        if not self._kept:
            return None
        best, chosen = np.inf, None
        for motion in self._kept:
            distance, along = _along(motion, world)
            if distance < best:
                best, chosen = distance, (motion, along)
        motion, along = chosen
        self._kept.remove(motion)
        self._kept.append(motion)
        change = np.zeros(motion.shapes_m.shape, np.float32)
        for share, lead in zip(along, motion.leads_m, strict=True):
            if share != 0.0:
                change += np.float32(share) * lead
        far = float(np.abs(change).max())
        return motion.shapes_m + min(1.0, FARTHEST_M / max(far, 1e-12)) * change

    def keep(self, worlds: list[World], shapes_m: np.ndarray, leads_m: np.ndarray) -> None:
        """Remember a motion; `leads_m` (P - 1, T, V, 3) of its twins.

        A motion without twins is given those of the one that foretold it: its leads have hardly turned.
        """
        for motion in self._kept:
            if motion.world == worlds[0] == motion.origin:
                motion.twins += worlds[1:]
                motion.leads_m += list(leads_m)
                return
        if len(worlds) == 1 and self._kept:
            last = self._kept[-1]
            origin, twins, leads = last.origin, last.twins, last.leads_m
        else:
            origin, twins, leads = worlds[0], list(worlds[1:]), list(leads_m)
        motion = Motion(world=worlds[0], shapes_m=shapes_m, origin=origin, twins=twins, leads_m=leads)
        others = [other for other in self._kept if other.world != worlds[0]]
        self._kept = [*others[-KEPT + 1 :], motion]


def on_finer(shapes_m: np.ndarray, coarse: Scene, fine: Scene) -> np.ndarray:
    """Shapes (T, V, 3) of a mesh on the one (T, W, 3) whose faces are a fourth: new vertices half-way."""
    cut = np.empty((len(shapes_m), len(fine.place), 3))
    cut[:, fine.place] = shapes_m[:, coarse.place[fine.between]].mean(2)
    return cut


def _along(motion: Motion, world: World) -> tuple[float, np.ndarray]:
    """How far a world is from a motion's, in steps of its twins, and how much of each twin's lead leads there."""
    rows = [_numbers(w) for w in (motion.world, world, motion.origin, *motion.twins)]
    table = np.array(rows)
    positive = (table > 0).all(0)
    table[:, positive] = np.log(table[:, positive])
    base, asked, origin, twins = table[0], table[1], table[2], table[3:]
    wanted = asked - base
    if not wanted.any():
        return 0.0, np.zeros(len(twins))
    if not len(twins):
        return float(np.abs(wanted).sum()) * 1e6, np.zeros(0)
    steps = twins - origin
    scale = np.maximum(np.abs(steps).max(0), 1e-9)
    along = np.linalg.lstsq((steps / scale).T, wanted / scale, rcond=1e-6)[0]
    left = np.abs((steps.T @ along - wanted) / scale).sum()
    return float(np.abs(along).sum() + 10.0 * left), along


def _numbers(world: World) -> list[float]:
    numbers: list[float] = []
    for field in fields(world):
        value = getattr(world, field.name)
        if field.name not in NOT_NUMBERS:
            numbers += list(np.ravel(value).astype(float))
    return numbers
