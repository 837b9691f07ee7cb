"""Blocks of vertices that move as one: single vertices, patches of neighbours, patches of patches, at last the whole cloth.

A sweep over vertices alone needs many rounds until a load that acts everywhere (the friction of a table, a hand that drags a
shirt) has passed through stiff cloth: each vertex is held by its neighbours. A translation of a patch leaves its inner elements
as they are, so that only what crosses its rim resists; the same Newton step on the same energy then carries the load in one go.
Patches are aggregates of a vertex (later: a patch) and its neighbours, as in aggregation multigrid (Vanek et al. 1996).
"""

import numpy as np
import warp as wp

from sim1.cloth.avbd.sheet import Part, Sheet, parts_of


@wp.struct
class Blocks:
    """All blocks of all levels behind one another; the first level's are the vertices. Lists of a block are CSR."""

    level: wp.array(dtype=wp.int32)  # (b,)
    home: wp.array2d(dtype=wp.int32)  # (level, v) block of a vertex
    members_from: wp.array(dtype=wp.int32)
    members: wp.array(dtype=wp.int32)  # vertices
    triangles_from: wp.array(dtype=wp.int32)
    triangles: wp.array(dtype=Part)  # of which some corners, not all, are members
    hinges_from: wp.array(dtype=wp.int32)
    hinges: wp.array(dtype=wp.vec2i)  # hinge, its one corner that is a member, or minus the bits of several
    edges_from: wp.array(dtype=wp.int32)
    edges: wp.array(dtype=wp.vec3i)  # edge, end that is a member, other end


def blocks_of(sheet: Sheet, world: np.ndarray, *, nested: bool) -> tuple[Blocks, list[np.ndarray]]:
    """Blocks of a cloth, and per level above the first the block ids of each colour; `nested` False: vertices alone."""
    edges, triangles, hinges = sheet.edge.numpy(), sheet.triangle.numpy(), sheet.hinge.numpy()
    vertex_count = len(world)
    homes = levels_of(edges, world) if nested else [np.arange(vertex_count)]
    first = np.cumsum([0] + [int(home.max()) + 1 for home in homes])
    pose = sheet.triangle_pose.numpy()
    gradients = np.stack([-(pose[:, 0] + pose[:, 1]), pose[:, 0], pose[:, 1]], axis=1)  # (t, corner, 2)
    rows: dict[str, list[np.ndarray]] = {name: [] for name in ("members", "triangles", "slopes", "hinges", "edges")}
    owners: dict[str, list[np.ndarray]] = {name: [] for name in ("members", "triangles", "hinges", "edges")}
    for home, start in zip(homes, first):
        owners["members"].append(home + start)
        rows["members"].append(np.arange(vertex_count))
        owner, item, mask = _crossing(home[triangles])
        bits = (mask[:, None] >> np.arange(3)) & 1
        owners["triangles"].append(owner + start)
        rows["triangles"].append(item)
        rows["slopes"].append(np.einsum("nc,ncj->nj", bits, gradients[item]))
        owner, item, mask = _crossing(home[hinges])
        owners["hinges"].append(owner + start)
        single = np.isin(mask, (1, 2, 4, 8))
        rows["hinges"].append(np.stack([item, np.where(single, np.log2(mask).astype(int), -mask)], axis=1))
        owner, item, mask = _crossing(home[edges])
        inside = (mask == 2).astype(int)
        owners["edges"].append(owner + start)
        rows["edges"].append(np.stack([item, edges[item, inside], edges[item, 1 - inside]], axis=1))
    blocks = Blocks()
    count = int(first[-1])
    kinds = {"members": wp.int32, "triangles": None, "hinges": wp.vec2i, "edges": wp.vec3i}
    for name, dtype in kinds.items():
        owner = np.concatenate(owners[name])
        order = np.argsort(owner, kind="stable")
        start = np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=count))])
        setattr(blocks, f"{name}_from", wp.array(start.astype(np.int32), dtype=wp.int32))
        items = np.concatenate(rows[name])[order].astype(np.int32)
        if name == "triangles":
            blocks.triangles = parts_of(sheet, items, np.concatenate(rows["slopes"])[order])
        else:
            setattr(blocks, name, wp.array(items, dtype=dtype))
    blocks.level = wp.array(np.repeat(np.arange(len(homes)), np.diff(first)).astype(np.int32), dtype=wp.int32)
    blocks.home = wp.array(np.stack([home + start for home, start in zip(homes, first)]).astype(np.int32))
    return blocks, [
        group + start for home, start in zip(homes[1:], first[1:]) for group in _colours(home[hinges], home[edges])
    ]


def levels_of(edges: np.ndarray, world: np.ndarray) -> list[np.ndarray]:
    """Block of each vertex (v,), level by level: vertices, patches until they have no neighbours, all cloth of a world (v,)."""
    homes = [np.arange(len(world))]
    while True:
        home = homes[-1]
        pairs = np.unique(np.sort(home[edges], axis=1), axis=0)
        pairs = pairs[pairs[:, 0] != pairs[:, 1]]
        if not len(pairs):
            _, whole = np.unique(world, return_inverse=True)
            return homes if whole.max() == home.max() else [*homes, whole]
        homes.append(_aggregates(pairs, int(home.max()) + 1)[home])


def _aggregates(pairs: np.ndarray, count: int) -> np.ndarray:
    """Patch of each node (n,): a node and its neighbours where none is taken yet; the rest joins a neighbour's patch."""
    both = np.concatenate([pairs, pairs[:, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    start = np.concatenate([[0], np.cumsum(np.bincount(both[:, 0], minlength=count))])
    patch = np.full(count, -1)
    made = 0
    for node in range(count):
        near = both[start[node] : start[node + 1], 1]
        if patch[node] < 0 and (patch[near] < 0).all():
            patch[node] = patch[near] = made
            made += 1
    core = patch.copy()
    for node in np.flatnonzero(patch < 0):
        near = both[start[node] : start[node + 1], 1]
        taken = core[near][core[near] >= 0]
        patch[node] = taken[0] if len(taken) else made
        made += not len(taken)
    return patch


def _crossing(corner_home: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Elements (n, k) given by the blocks of their corners: owner, element and corner bits of each block that has some corners."""
    bit = 1 << np.arange(corner_home.shape[1])
    owners, items, masks = [], [], []
    for corner in range(corner_home.shape[1]):
        same = corner_home == corner_home[:, corner : corner + 1]
        mask = (same * bit).sum(axis=1)
        first = ~same[:, :corner].any(axis=1)
        kept = np.flatnonzero(first & ~same.all(axis=1))
        owners.append(corner_home[kept, corner])
        items.append(kept)
        masks.append(mask[kept])
    return np.concatenate(owners), np.concatenate(items), np.concatenate(masks)


def _colours(*corner_homes: np.ndarray) -> list[np.ndarray]:
    """Blocks in groups of which no two share an element; greedy, in the order of their numbers."""
    neighbours: dict[int, set[int]] = {}
    for homes in corner_homes:
        for corners in homes.tolist():
            for block in corners:
                neighbours.setdefault(block, set()).update(corners)
    colour: dict[int, int] = {}
    for block in sorted(neighbours):
        used = {colour[other] for other in neighbours[block] if other in colour}
        colour[block] = next(c for c in range(len(used) + 1) if c not in used)
    return [
        np.array([b for b in sorted(colour) if colour[b] == c], dtype=np.int32)
        for c in range(max(colour.values(), default=-1) + 1)
    ]
