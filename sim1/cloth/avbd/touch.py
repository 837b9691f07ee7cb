"""Contacts as records of up to four cloth vertices along a normal, whatever touches: a solid or the cloth itself."""

import warp as wp

from sim1.cloth.avbd.iterate import Iterate, StepNumbers


@wp.struct
class Touches:
    """Contact records; the point in contact is sum(weight * x), and it is pushed along the normal up to `offset`.

    Records of a vertex are linked: `head[v]`, then `after[4 record + slot]`, each 4 record + slot, -1 at the end.
    """

    count: wp.array(dtype=wp.int32)  # (1,)
    capacity: wp.int32
    vertex: wp.array(dtype=wp.vec4i)  # -1: unused
    weight: wp.array(dtype=wp.vec4)
    normal: wp.array(dtype=wp.vec3)
    offset: wp.array(dtype=float)  # [m]
    anchor: wp.array(dtype=wp.vec3)  # where the point would be if it had moved with what it touches [m]
    stiffness: wp.array(dtype=float)  # [N/m]
    damping: wp.array(dtype=float)  # of approach [N s/m]
    friction: wp.array(dtype=float)
    skew: wp.array(dtype=float)  # friction is 1 + skew times that along the world's x, 1 - skew times along y
    shape: wp.array(dtype=wp.int32)  # -1: cloth
    near: wp.array(dtype=wp.int32)  # 0: too far to push in this step
    first_side: wp.array(dtype=wp.int32)  # slots before this one lie on the normal's side
    parting: wp.array(dtype=wp.vec3)  # direction along which the two sides stay apart until the next search
    least: wp.array(dtype=float)  # distance that stays between them [m]
    head: wp.array(dtype=wp.int32)  # (v,) of records that are near
    after: wp.array(dtype=wp.int32)
    wide_head: wp.array(dtype=wp.int32)  # (v,) of all records of the last search
    wide_after: wp.array(dtype=wp.int32)


@wp.struct
class Guard:
    """What keeps layers from passing through each other between two searches."""

    reach: float  # distance from the expected motion that the search looked at [m]; 0: no self-contact
    share: float  # of the room to a neighbour that a move may use
    seen: wp.array(dtype=wp.vec3)  # (v,) where the last search expected the vertex after its step [m]
    room: wp.array(dtype=float)  # (v,) a way this long needs no look at the neighbours [m]
    cut: wp.array(dtype=wp.int32)  # (1,) moves that were cut since


@wp.func
def point_of(vertex: wp.vec4i, weight: wp.vec4, x: wp.array(dtype=wp.vec3)):
    """sum(weight * x)."""
    point = weight[0] * x[vertex[0]]
    if vertex[1] >= 0:
        point += weight[1] * x[vertex[1]]
    if vertex[2] >= 0:
        point += weight[2] * x[vertex[2]]
    if vertex[3] >= 0:
        point += weight[3] * x[vertex[3]]
    return point


@wp.func
def link(vertex: wp.vec4i, record: int, head: wp.array(dtype=wp.int32), after: wp.array(dtype=wp.int32)):
    """Hang a record into the lists of its vertices."""
    for slot in range(4):
        if vertex[slot] >= 0:
            item = 4 * record + slot
            after[item] = wp.atomic_exch(head, vertex[slot], item)


@wp.func
def push(touches: wp.array(dtype=Touches), now: wp.array(dtype=Iterate), step: StepNumbers, record: int, move: wp.vec3):
    """Force [N] and block [N/m] at the point of a record: penalty, damping of approach, regularised Coulomb friction.

    An open contact that `move` of the point would close counts as closed already, pulling by as much as it is open: with the
    Newton step of an energy that sets in only at the contact a vertex would fall through it and be thrown back for ever.
    Friction follows mu N (2 s - s^2) with s = slip speed / `friction_speed` up to 1 (Li et al. 2020, eq. 13).
    """
    normal = touches[0].normal[record]
    point = point_of(touches[0].vertex[record], touches[0].weight[record], now[0].x)
    depth = touches[0].offset[record] - wp.dot(normal, point)
    force = wp.vec3(0.0)
    block = wp.mat33(0.0)
    if wp.max(depth, depth - wp.dot(normal, move)) > 0.0:
        along = wp.outer(normal, normal)
        stiffness = touches[0].stiffness[record]
        load = stiffness * depth
        moved = point - touches[0].anchor[record]
        approach = wp.dot(normal, moved)
        if approach < 0.0:
            damping = touches[0].damping[record] / step.dt
            load -= damping * approach
            stiffness += damping
        force = load * normal
        block = stiffness * along
        load = wp.max(load, 0.0)
        slip = moved - approach * normal
        distance = wp.length(slip)
        smooth = step.friction_speed * step.dt
        ratio = float(0.0)
        if distance > smooth:
            ratio = 1.0 / distance
        else:
            ratio = (2.0 - distance / smooth) / smooth
        grip = touches[0].friction[record] * load * ratio
        force -= grip * slip
        block += grip * (wp.identity(n=3, dtype=float) - along)
        lean = grip * touches[0].skew[record]
        if lean != 0.0:
            force -= lean * wp.vec3(slip[0], -slip[1], 0.0)
            block += lean * wp.diag(wp.vec3(1.0, -1.0, 0.0))
    return force, block
