"""Penetration avoidance: how far a block may move so that no layer passes through another.

The paper (appendix A) cuts every vertex's step to 0.42 of the distance to the nearest primitive. That also stops layers that
travel together: a shirt that is lifted would tear out of the fingers. Here each pair found by the search keeps its direction
until the next one, and the two sides may not pass each other along it. Two convex primitives apart along the same direction
before and after a straight move were apart on the way; and moves of both together change nothing.
"""

import warp as wp

from sim1.cloth.avbd.blocks import Blocks
from sim1.cloth.avbd.iterate import Iterate
from sim1.cloth.avbd.touch import Guard, Touches


@wp.func
def allowed(
    layers: wp.array(dtype=Touches),
    now: wp.array(dtype=Iterate),
    guard: wp.array(dtype=Guard),
    blocks: wp.array(dtype=Blocks),
    b: int,
    move: wp.vec3,
):
    """Fraction of a block's move that keeps every pair apart, and every member within what the search has seen.

    `room` makes most looks needless: the rooms of the two sides of a pair together never exceed the distance left between them.
    """
    fraction = float(1.0)
    size = wp.length(move)
    level = blocks[0].level[b]
    for i in range(blocks[0].members_from[b], blocks[0].members_from[b + 1]):
        v = blocks[0].members[i]
        off = wp.length(now[0].x[v] - guard[0].seen[v])
        then = wp.length(now[0].x[v] + move - guard[0].seen[v])
        most = guard[0].share * guard[0].reach
        if then > most and then > off:
            fraction = wp.min(fraction, wp.max(most - off, 0.0) / size)
        if size > guard[0].room[v]:
            guard[0].room[v] = guard[0].reach
            node = int(layers[0].wide_head[v])
            while node >= 0:
                fraction = wp.min(fraction, passing(layers, now, guard, blocks, level, b, node / 4, move))
                node = int(layers[0].wide_after[node])
        else:
            guard[0].room[v] = guard[0].room[v] - size
    if fraction < 1.0:
        wp.atomic_add(guard[0].cut, 0, 1)
    return fraction


@wp.func
def passing(
    layers: wp.array(dtype=Touches),
    now: wp.array(dtype=Iterate),
    guard: wp.array(dtype=Guard),
    blocks: wp.array(dtype=Blocks),
    level: int,
    b: int,
    record: int,
    move: wp.vec3,
):
    """Fraction of a block's move that one pair allows; shares what distance will be left among the rooms of its vertices."""
    direction = layers[0].parting[record]
    vertex = layers[0].vertex[record]
    low = float(1.0e9)
    high = float(-1.0e9)
    first = int(0)
    second = int(0)
    for slot in range(4):
        place = wp.dot(direction, now[0].x[vertex[slot]])
        inside = wp.where(blocks[0].home[level, vertex[slot]] == b, 1, 0)
        if slot < layers[0].first_side[record]:
            low = wp.min(low, place)
            first += inside
        else:
            high = wp.max(high, place)
            second += inside
    slack = wp.max(low - high - layers[0].least[record], 0.0)
    approach = wp.dot(direction, move)
    if first + second == 4:
        approach = 0.0
    elif second == 0:
        approach = -approach
    elif first > 0:
        approach = wp.abs(approach)
    usable = guard[0].share * slack
    left = 0.5 * (slack - wp.clamp(approach, 0.0, usable))
    for slot in range(4):
        wp.atomic_min(guard[0].room, vertex[slot], left)
    if approach <= usable:
        return 1.0
    return usable / approach
