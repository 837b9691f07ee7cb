"""The sweep: every vertex to the minimum of its own energy, then the multipliers; fused for a CPU, by colour for a GPU."""

import warp as wp

from sim1.cloth.avbd.elastic import hinge, limit, membrane, refresh_hinge, update_limit
from sim1.cloth.avbd.iterate import Iterate, StepNumbers
from sim1.cloth.avbd.layers import refresh_layer
from sim1.cloth.avbd.sheet import Sheet
from sim1.cloth.avbd.touch import Guard, Touches, hold_apart, push

TERMS = ("inertia", "effects", "membrane", "bending", "strain limit", "solid contact", "self-contact")


@wp.func
def total(sheet: Sheet, now: Iterate, step: StepNumbers, solids: Touches, layers: Touches, v: int, term: int):
    """Force and Hessian block of a vertex; of all terms (`term` -1) or of one alone, for finding what broke."""
    at = now.x[v]
    stiffness = sheet.mass[v] * step.inertia
    force = wp.vec3(0.0)
    block = wp.mat33(0.0)
    if term < 0 or term == 0:
        force = -stiffness * (at - now.target[v])
        block = stiffness * wp.identity(n=3, dtype=float)
    if term < 0 or term == 1:
        slope = now.slope[v]
        force += now.force[v] - slope * (at - now.start[v])
        block += slope
    if term < 0 or term == 2:
        for i in range(sheet.triangles_from[v], sheet.triangles_from[v + 1]):
            item = sheet.triangles_of[i]
            f, h = membrane(sheet, now, step, item[0], item[1])
            force += f
            block += h
    if term < 0 or term == 3:
        for i in range(sheet.hinges_from[v], sheet.hinges_from[v + 1]):
            item = sheet.hinges_of[i]
            f, h = hinge(sheet, now, step, item[0], item[1])
            force += f
            block += h
    if term < 0 or term == 4:
        for i in range(sheet.edges_from[v], sheet.edges_from[v + 1]):
            item = sheet.edges_of[i]
            f, h = limit(sheet, now, step, item[0], at, now.x[item[1]])
            force += f
            block += h
    if term < 0 or term == 5:
        node = int(solids.head[v])
        while node >= 0:
            f, h = push(solids, now, step, node / 4)
            weight = solids.weight[node / 4][node % 4]
            force += weight * f
            block += weight * weight * h
            node = int(solids.after[node])
    if term < 0 or term == 6:
        node = int(layers.head[v])
        while node >= 0:
            if layers.near[node / 4] != 0:
                f, h = push(layers, now, step, node / 4)
                weight = layers.weight[node / 4][node % 4]
                force += weight * f
                block += weight * weight * h
            node = int(layers.after[node])
    return force, block


@wp.func
def settle(
    sheet: Sheet,
    now: Iterate,
    step: StepNumbers,
    solids: Touches,
    layers: Touches,
    guard: Guard,
    v: int,
):
    """Newton step of one vertex on its own energy, held on its side of every layer (x = x + s A^-1 b)."""
    if sheet.movable[v] != 0:
        force, block = total(sheet, now, step, solids, layers, v, -1)
        at = now.x[v]
        wanted = at + step.over_relaxation * (wp.inverse(block) * force)
        size = wp.length(wanted)
        if not (size < 1.0e6):
            name_culprit(sheet, now, step, solids, layers, v)
            wanted = at
        if guard.reach > 0.0:
            wanted = hold_apart(layers, guard, v, wanted)
        moved = wanted - at
        now.x[v] = wanted
        for i in range(sheet.hinges_from[v], sheet.hinges_from[v + 1]):
            item = sheet.hinges_of[i]
            wp.atomic_add(now.hinge_now, item[0], wp.dot(now.hinge_slope[item[0], item[1]], moved))


@wp.func
def name_culprit(sheet: Sheet, now: Iterate, step: StepNumbers, solids: Touches, layers: Touches, v: int):
    """Note the first vertex whose step is not a number, and the term that made it so."""
    if wp.atomic_cas(now.broken, 0, 0, v + 1) == 0:
        now.broken[2] = step.step
        now.broken[1] = -1
        for term in range(7):
            force, block = total(sheet, now, step, solids, layers, v, term)
            size = wp.length(force) + wp.length(block[0]) + wp.length(block[1]) + wp.length(block[2])
            if now.broken[1] < 0 and not (size < 1.0e12):
                now.broken[1] = term


@wp.kernel(enable_backward=False)
def sweep_fused(
    sheet: Sheet,
    now: Iterate,
    step: StepNumbers,
    solids: Touches,
    layers: Touches,
    guard: Guard,
    iterations: int,
):
    """All iterations of a step in one launch: on a CPU a launch runs on one thread and costs more than many vertices."""
    vertex_count = sheet.mass.shape[0]
    for sweep in range(iterations):
        for h in range(sheet.hinge.shape[0]):
            refresh_hinge(sheet, now, h)
        for record in range(wp.min(layers.count[0], layers.capacity)):
            refresh_layer(layers, now, sweep, record)
        for v in range(vertex_count):
            settle(sheet, now, step, solids, layers, guard, v)
        for e in range(sheet.edge.shape[0]):
            update_limit(sheet, now, step, e)


@wp.kernel(enable_backward=False)
def sweep_hinges(sheet: Sheet, now: Iterate):
    """`refresh_hinge` of all."""
    refresh_hinge(sheet, now, wp.tid())


@wp.kernel(enable_backward=False)
def sweep_layers(layers: Touches, now: Iterate, sweep: int):
    """`refresh_layer` of all records in use."""
    record = wp.tid()
    if record < wp.min(layers.count[0], layers.capacity):
        refresh_layer(layers, now, sweep, record)


@wp.kernel(enable_backward=False)
def sweep_colour(
    colour: wp.array(dtype=wp.int32),
    sheet: Sheet,
    now: Iterate,
    step: StepNumbers,
    solids: Touches,
    layers: Touches,
    guard: Guard,
):
    """`settle` of all vertices of a colour; no two of them share a triangle."""
    settle(sheet, now, step, solids, layers, guard, colour[wp.tid()])


@wp.kernel(enable_backward=False)
def sweep_limits(sheet: Sheet, now: Iterate, step: StepNumbers):
    """`update_limit` of all."""
    update_limit(sheet, now, step, wp.tid())
