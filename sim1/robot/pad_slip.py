"""How far cloth slips between closed pads: what is held should move with the fingers and not through them."""

import numpy as np

CLOSED = 0.06  # openness of a gripper that may hold cloth
STILL = 0.005  # of openness: closing has ended, opening has not begun
SETTLED = 2  # frames after closing
THICK_M = 0.006  # cloth this near to the middle plane lies between the pads


def pad_slip_m(
    garment_m: np.ndarray, tool_to_world: np.ndarray, openness: np.ndarray, width_m: float, length_m: float
) -> float | None:
    """Largest way [m], in the tool's frame, of a vertex from when the pads have closed on it to when they begin to open.

    None where no pads ever closed on a vertex.

    Args:
        garment_m: (T, v, 3), world frame.
        tool_to_world: (T, 2, 4, 4); fingers end at the tool's origin, lie along -x, open along y.
        openness: (T, 2), 0 closed.
        width_m: of a finger, along the tool's z.
        length_m: of a finger.
    """
    slips = []
    for arm in range(2):
        for first, last in _holds(openness[:, arm]):
            start, end = (_in_tool(garment_m[t], tool_to_world[t, arm]) for t in (first, last))
            between = (np.abs(start[:, 1]) < THICK_M) & (np.abs(start[:, 2]) < 0.5 * width_m)
            between &= (start[:, 0] < 0.0) & (start[:, 0] > -length_m)
            slips += np.linalg.norm(end - start, axis=1)[between].tolist()
    return max(slips, default=None)


def _holds(openness: np.ndarray) -> list[tuple[int, int]]:
    """First and last frame of each time that a gripper (T,) was closed and still."""
    edges = np.diff((openness < CLOSED).astype(int), prepend=0, append=0)
    found = []
    for start, end in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
        part = openness[start:end]
        still = start + np.flatnonzero(part <= part.min() + STILL)
        if len(still) > SETTLED:
            found.append((int(still[0]) + SETTLED, int(still[-1])))
    return found


def _in_tool(points_m: np.ndarray, tool_to_world: np.ndarray) -> np.ndarray:
    return (points_m - tool_to_world[:3, 3]) @ tool_to_world[:3, :3]
