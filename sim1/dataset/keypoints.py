"""Which garment vertices stand for the whole garment in a state vector."""

import numpy as np

# LeRobot's policies take every column whose name begins with "observation" for an input, and one of these names for the
# environment's state. Where the garment is, only a simulator knows: a column of another name they leave alone.
KEYPOINTS = "privileged.garment_keypoints"


def keypoint_indices(rest_m: np.ndarray, count: int) -> np.ndarray:
    """Vertices that cover the garment evenly: farthest-point sampling on its rest shape.

    Starts with the vertex farthest from the mean; ties go to the lower index, so a mesh has one answer.

    Args:
        rest_m: (v, 3).
        count: number of vertices to choose.

    Returns:
        (count,) int, in order of choice.

    Raises:
        ValueError: fewer vertices than `count`.
    """
    if len(rest_m) < count:
        raise ValueError(f"cannot choose {count} keypoints among {len(rest_m)} vertices")
    chosen = [int(np.argmax(np.linalg.norm(rest_m - rest_m.mean(axis=0), axis=1)))]
    nearest = np.full(len(rest_m), np.inf)
    while len(chosen) < count:
        nearest = np.minimum(nearest, np.linalg.norm(rest_m - rest_m[chosen[-1]], axis=1))
        chosen.append(int(np.argmax(nearest)))
    return np.array(chosen)
