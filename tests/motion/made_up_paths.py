"""Ways of two tools whose figures are known: minimum jerk along a line, and arches that differ a little."""

import numpy as np

from sim1.motion.likeness.comparison import Paths
from sim1.motion.likeness.features import Movement
from sim1.motion.poses import ToolPath


def reach(count=91, size_m=0.3):
    """Minimum jerk from rest to rest along a straight line, (count, 3)."""
    s = np.linspace(0, 1, count)
    return (10 * s**3 - 15 * s**4 + 6 * s**5)[:, None] * np.array([size_m, 0, 0])


def arched(rng, count=60, shake_m=0.0):
    """Both tools over an arch whose height varies a little."""
    way = reach(count, 0.25)
    s = np.linspace(0, 1, count)
    way[:, 2] = (0.06 + 0.005 * rng.standard_normal()) * np.sin(np.pi * s) ** 2
    way += shake_m * np.sin(np.pi * s)[:, None] ** 2 * rng.standard_normal((count, 3))
    both = np.stack([way, way + np.array([0, 0.3, 0])], axis=1)
    return ToolPath(position_m=both, rotation=np.tile(np.eye(3), (count, 2, 1, 1)), openness=np.ones((count, 2)))


def some_paths(count, seed, shake_m=0.0, source_count=10):
    """Paths of one transition between two rests, said to be joined a third of the way; the sources take turns."""
    rng = np.random.default_rng(seed)
    moves = [arched(rng, int(rng.integers(55, 66)), shake_m) for _ in range(count)]
    rested = [np.concatenate([way.position_m[:1]] * 5 + [way.position_m] + [way.position_m[-1:]] * 5) for way in moves]
    return Paths(
        tools=rested,
        joints=rested,
        joins=[[len(way) // 3] for way in rested],
        movements=[
            Movement(path=way, order=0, sources=frozenset({f"{i % source_count}"})) for i, way in enumerate(moves)
        ],
    )
