"""Outward normals of a point cloud."""

import numpy as np

_NEIGHBOURS = 12
_LINKS = 8  # of the graph along which the orientation spreads


def oriented_normals(
    points: np.ndarray, given: np.ndarray, view: np.ndarray, scanner_to_world: np.ndarray
) -> tuple[np.ndarray, dict[str, float]]:
    """Unit normals of points, all on the same side of the fabric, outwards.

    Directions by the principal axes of the neighbours. A scanner sees a point from the side that its normal points to, but a
    viewpoint that looks in at the neck or the hem sees the fabric's inside, and its normals come out flipped. So the sign
    spreads along a minimum spanning tree of the neighbours (Hoppe 1992), and each connected patch takes the side that most
    of its points were seen from; without viewpoints, the side of the given normals; without those, away from the middle.

    Args:
        points: (n, 3) m.
        given: (n, 3) normals of the file, zeros where unknown.
        view: (n,) index into the poses, -1 where unknown.
        scanner_to_world: (v, 4, 4).

    Returns:
        Normals (n, 3), and the share of the points that voted, and of these that were overruled.
    """
    from scipy.spatial import cKDTree

    points = points.astype(float)
    _, near = cKDTree(points).query(points, k=min(_NEIGHBOURS, len(points)))
    offsets = points[near] - points[near].mean(axis=1, keepdims=True)
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", offsets, offsets))
    normals = axes[:, :, 0]
    votes = _votes(points, normals, given, view, scanner_to_world)
    sign = _spread_sign(points, normals, near[:, 1 : _LINKS + 1], votes)
    voting = votes != 0
    overruled = float((votes[voting] != sign[voting]).mean()) if voting.any() else 0.0
    return normals * sign[:, None], {"voting": float(voting.mean()), "overruled": overruled}


def _votes(
    points: np.ndarray, normals: np.ndarray, given: np.ndarray, view: np.ndarray, poses: np.ndarray
) -> np.ndarray:
    """+1 where the normal faces its scanner, or agrees with the file's, -1 where it does not, 0 unknown."""
    votes = np.sign((normals * given).sum(axis=1))
    known = view >= 0
    if len(poses) and known.any():
        toward = poses[view[known], :3, 3] - points[known]
        votes[known] = np.sign((normals[known] * toward).sum(axis=1))
    return votes


def _spread_sign(points: np.ndarray, normals: np.ndarray, near: np.ndarray, votes: np.ndarray) -> np.ndarray:
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree

    count = len(points)
    rows, columns = np.repeat(np.arange(count), near.shape[1]), near.ravel()
    agreement = (normals[rows] * normals[columns]).sum(axis=1)
    cost = 1.0 - np.abs(agreement) + 1e-6
    graph = coo_matrix((cost, (rows, columns)), shape=(count, count)).tocsr()
    tree = minimum_spanning_tree(graph.maximum(graph.T))
    _, patch = connected_components(tree, directed=False)
    sign = np.ones(count)
    middle = points.mean(axis=0)
    for label in range(patch.max() + 1):
        members = np.flatnonzero(patch == label)
        order, parent = breadth_first_order(tree, members[0], directed=False)
        for child in order[1:]:
            before = parent[child]
            sign[child] = sign[before] if normals[child] @ normals[before] >= 0 else -sign[before]
        ballot = (votes[members] * sign[members]).sum()
        if ballot == 0:
            ballot = (sign[members] * ((points[members] - middle) * normals[members]).sum(axis=1)).sum()
        if ballot < 0:
            sign[members] *= -1
    return sign
