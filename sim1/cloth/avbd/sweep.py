"""The sweep: every block to the minimum of its own energy, then the multipliers; fused for a CPU, by colour for a GPU."""

import warp as wp

from sim1.cloth.avbd.apart import allowed
from sim1.cloth.avbd.blocks import Blocks
from sim1.cloth.avbd.elastic import hinge, hinge_slope, limit, membrane, refresh_hinge, update_limit
from sim1.cloth.avbd.iterate import Iterate, StepNumbers
from sim1.cloth.avbd.layers import refresh_layer
from sim1.cloth.avbd.sheet import Sheet
from sim1.cloth.avbd.touch import Guard, Touches, point_of, push

COARSE_EVERY = 2  # sweeps
SMALL_M = wp.constant(5.0e-6)  # a move below this that closes a contact does no harm
TERMS = ("inertia", "effects", "membrane", "bending", "strain limit", "solid contact", "self-contact")


@wp.func
def together(touches: wp.array(dtype=Touches), blocks: wp.array(dtype=Blocks), b: int, record: int):
    """Share of a contact's point that moves with a block."""
    level = blocks[0].level[b]
    vertex = touches[0].vertex[record]
    weight = touches[0].weight[record]
    share = float(0.0)
    for slot in range(4):
        if vertex[slot] >= 0 and blocks[0].home[level, vertex[slot]] == b:
            share += weight[slot]
    return share


@wp.func
def touched(
    touches: wp.array(dtype=Touches),
    now: wp.array(dtype=Iterate),
    step: StepNumbers,
    blocks: wp.array(dtype=Blocks),
    b: int,
    v: int,
    move: wp.vec3,
):
    """Force and block of all contacts of a member, as far as they move with the whole block by `move`."""
    force = wp.vec3(0.0)
    hessian = wp.mat33(0.0)
    node = int(touches[0].head[v])
    while node >= 0:
        record = node / 4
        share = together(touches, blocks, b, record)
        f, h = push(touches, now, step, record, share * move)
        weight = touches[0].weight[record][node % 4]
        force += weight * f
        hessian += weight * share * h
        node = int(touches[0].after[node])
    return force, hessian


@wp.func
def closes(
    touches: wp.array(dtype=Touches),
    now: wp.array(dtype=Iterate),
    blocks: wp.array(dtype=Blocks),
    b: int,
    move: wp.vec3,
):
    """Whether a block's move closes a contact that is open."""
    found = wp.bool(False)
    for i in range(blocks[0].members_from[b], blocks[0].members_from[b + 1]):
        node = int(touches[0].head[blocks[0].members[i]])
        while node >= 0:
            record = node / 4
            normal = touches[0].normal[record]
            point = point_of(touches[0].vertex[record], touches[0].weight[record], now[0].x)
            depth = touches[0].offset[record] - wp.dot(normal, point)
            if depth <= 0.0 and depth > together(touches, blocks, b, record) * wp.dot(normal, move):
                found = wp.bool(True)
            node = int(touches[0].after[node])
    return found


@wp.func
def total(
    sheet: wp.array(dtype=Sheet),
    blocks: wp.array(dtype=Blocks),
    now: wp.array(dtype=Iterate),
    step: StepNumbers,
    solids: wp.array(dtype=Touches),
    layers: wp.array(dtype=Touches),
    b: int,
    term: int,
    move: wp.vec3,
):
    """Force and Hessian block of a block; of all terms (`term` -1) or of one, for finding what broke."""
    force = wp.vec3(0.0)
    hessian = wp.mat33(0.0)
    for i in range(blocks[0].members_from[b], blocks[0].members_from[b + 1]):
        v = blocks[0].members[i]
        away = now[0].x[v] - now[0].start[v]
        if term < 0 or term == 0:
            stiffness = sheet[0].mass[v] * wp.where(now[0].fresh[v] != 0, 1.0 / (step.dt * step.dt), step.inertia)
            force -= stiffness * (now[0].x[v] - now[0].target[v])
            hessian += stiffness * wp.identity(n=3, dtype=float)
        if term < 0 or term == 1:
            force += now[0].force[v] - now[0].slope[v] * away
            hessian += now[0].slope[v]
        if term < 0 or term == 5:
            f, h = touched(solids, now, step, blocks, b, v, move)
            force += f
            hessian += h
        if term < 0 or term == 6:
            f, h = touched(layers, now, step, blocks, b, v, move)
            force += f
            hessian += h
    if term < 0 or term == 2:
        for i in range(blocks[0].triangles_from[b], blocks[0].triangles_from[b + 1]):
            f, h = membrane(blocks[0].triangles[i], sheet[0].slack, sheet[0].growth, now, step)
            force += f
            hessian += h
    if term < 0 or term == 3:
        for i in range(blocks[0].hinges_from[b], blocks[0].hinges_from[b + 1]):
            f, h = hinge(now, blocks[0].hinges[i][0], blocks[0].hinges[i][1])
            force += f
            hessian += h
    if term < 0 or term == 4:
        for i in range(blocks[0].edges_from[b], blocks[0].edges_from[b + 1]):
            item = blocks[0].edges[i]
            f, h = limit(now, item[0], now[0].x[item[1]], now[0].x[item[2]])
            force += f
            hessian += h
    return force, hessian


@wp.func
def movable(sheet: wp.array(dtype=Sheet), blocks: wp.array(dtype=Blocks), b: int):
    """Whether no member of a block is held."""
    free = wp.bool(True)
    for i in range(blocks[0].members_from[b], blocks[0].members_from[b + 1]):
        if sheet[0].movable[blocks[0].members[i]] == 0:
            free = wp.bool(False)
    return free


@wp.func
def follow(
    sheet: wp.array(dtype=Sheet),
    blocks: wp.array(dtype=Blocks),
    now: wp.array(dtype=Iterate),
    layers: wp.array(dtype=Touches),
    guard: wp.array(dtype=Guard),
    b: int,
):
    """Move a block by the mean of what its members still wish; from the whole down, so that layers travel together."""
    if movable(sheet, blocks, b):
        move = wp.vec3(0.0)
        for i in range(blocks[0].members_from[b], blocks[0].members_from[b + 1]):
            v = blocks[0].members[i]
            move += now[0].wish[v] - now[0].x[v]
        move /= float(blocks[0].members_from[b + 1] - blocks[0].members_from[b])
        if wp.length(move) > 0.0:
            move = allowed(layers, now, guard, blocks, b, move) * move
            for i in range(blocks[0].members_from[b], blocks[0].members_from[b + 1]):
                now[0].x[blocks[0].members[i]] = now[0].x[blocks[0].members[i]] + move


@wp.func
def settle(
    sheet: wp.array(dtype=Sheet),
    blocks: wp.array(dtype=Blocks),
    now: wp.array(dtype=Iterate),
    step: StepNumbers,
    solids: wp.array(dtype=Touches),
    layers: wp.array(dtype=Touches),
    guard: wp.array(dtype=Guard),
    b: int,
):
    """Newton step of one block on its own energy, each member held on its side of every layer (x = x + s A^-1 b)."""
    if movable(sheet, blocks, b):
        force, hessian = total(sheet, blocks, now, step, solids, layers, b, -1, wp.vec3(0.0))
        move = wp.inverse(hessian) * force
        size = wp.length(move)
        if size > SMALL_M and (closes(solids, now, blocks, b, move) or closes(layers, now, blocks, b, move)):
            force, hessian = total(sheet, blocks, now, step, solids, layers, b, -1, move)
            move = wp.inverse(hessian) * force
        if not (wp.length(move) < 1.0e6):
            name_culprit(sheet, blocks, now, step, solids, layers, b)
            move = wp.vec3(0.0)
        if guard[0].reach > 0.0:
            move = allowed(layers, now, guard, blocks, b, move) * move
        for i in range(blocks[0].members_from[b], blocks[0].members_from[b + 1]):
            v = blocks[0].members[i]
            now[0].x[v] = now[0].x[v] + move
        for i in range(blocks[0].hinges_from[b], blocks[0].hinges_from[b + 1]):
            item = blocks[0].hinges[i]
            wp.atomic_add(now[0].hinge_moment, item[0], wp.dot(hinge_slope(now, item[0], item[1]), move))


@wp.func
def name_culprit(
    sheet: wp.array(dtype=Sheet),
    blocks: wp.array(dtype=Blocks),
    now: wp.array(dtype=Iterate),
    step: StepNumbers,
    solids: wp.array(dtype=Touches),
    layers: wp.array(dtype=Touches),
    b: int,
):
    """Note the first vertex whose step is not a number, and the term that made it so."""
    if wp.atomic_cas(now[0].broken, 0, 0, blocks[0].members[blocks[0].members_from[b]] + 1) == 0:
        now[0].broken[2] = step.step
        now[0].broken[1] = -1
        for term in range(7):
            force, hessian = total(sheet, blocks, now, step, solids, layers, b, term, wp.vec3(0.0))
            size = wp.length(force) + wp.length(hessian[0]) + wp.length(hessian[1]) + wp.length(hessian[2])
            if now[0].broken[1] < 0 and not (size < 1.0e12):
                now[0].broken[1] = term


@wp.kernel(enable_backward=False)
def sweep_fused(
    sheet: wp.array(dtype=Sheet),
    blocks: wp.array(dtype=Blocks),
    now: wp.array(dtype=Iterate),
    step: StepNumbers,
    solids: wp.array(dtype=Touches),
    layers: wp.array(dtype=Touches),
    guard: wp.array(dtype=Guard),
    iterations: int,
):
    """All iterations of a step in one launch: on a CPU a launch runs on one thread and costs more than many vertices."""
    count = blocks[0].level.shape[0]
    vertex_count = now[0].x.shape[0]
    if guard[0].reach > 0.0:
        for b in range(count):
            follow(sheet, blocks, now, layers, guard, count - 1 - b)
    for sweep in range(iterations):
        if sweep % 2 == 0:  # between, angles follow the moves along the slopes of the sweep before
            for h in range(sheet[0].hinge.shape[0]):
                refresh_hinge(sheet, now, step, h)
        for record in range(wp.min(layers[0].count[0], layers[0].capacity)):
            refresh_layer(layers, now, sweep, record)
        last = wp.where(sweep % COARSE_EVERY == 0, count, vertex_count)
        for b in range(last):
            settle(sheet, blocks, now, step, solids, layers, guard, b)
        for e in range(sheet[0].edge.shape[0]):
            update_limit(sheet, now, step, e)


@wp.kernel(enable_backward=False)
def follow_colour(
    colour: wp.array(dtype=wp.int32),
    sheet: wp.array(dtype=Sheet),
    blocks: wp.array(dtype=Blocks),
    now: wp.array(dtype=Iterate),
    layers: wp.array(dtype=Touches),
    guard: wp.array(dtype=Guard),
):
    """`follow` of all blocks of a colour."""
    follow(sheet, blocks, now, layers, guard, colour[wp.tid()])


@wp.kernel(enable_backward=False)
def sweep_hinges(sheet: wp.array(dtype=Sheet), now: wp.array(dtype=Iterate), step: StepNumbers):
    """`refresh_hinge` of all."""
    refresh_hinge(sheet, now, step, wp.tid())


@wp.kernel(enable_backward=False)
def sweep_layers(layers: wp.array(dtype=Touches), now: wp.array(dtype=Iterate), sweep: int):
    """`refresh_layer` of all records in use."""
    record = wp.tid()
    if record < wp.min(layers[0].count[0], layers[0].capacity):
        refresh_layer(layers, now, sweep, record)


@wp.kernel(enable_backward=False)
def sweep_colour(
    colour: wp.array(dtype=wp.int32),
    sheet: wp.array(dtype=Sheet),
    blocks: wp.array(dtype=Blocks),
    now: wp.array(dtype=Iterate),
    step: StepNumbers,
    solids: wp.array(dtype=Touches),
    layers: wp.array(dtype=Touches),
    guard: wp.array(dtype=Guard),
):
    """`settle` of all blocks of a colour; no two of them share a triangle."""
    settle(sheet, blocks, now, step, solids, layers, guard, colour[wp.tid()])


@wp.kernel(enable_backward=False)
def sweep_limits(sheet: wp.array(dtype=Sheet), now: wp.array(dtype=Iterate), step: StepNumbers):
    """`update_limit` of all."""
    update_limit(sheet, now, step, wp.tid())
