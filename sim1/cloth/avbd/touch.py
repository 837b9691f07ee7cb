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
    shape: wp.array(dtype=wp.int32)  # -1: cloth
    near: wp.array(dtype=wp.int32)  # 0: too far to push in this step
    plane: wp.array(dtype=wp.vec4)  # normal and offset of the plane that holds both sides apart; zero: none
    first_side: wp.array(dtype=wp.int32)  # slots before this one lie on the positive side
    head: wp.array(dtype=wp.int32)  # (v,)
    after: wp.array(dtype=wp.int32)


@wp.struct
class Guard:
    """What keeps layers from passing through each other between two searches."""

    reach: float  # distance looked at by the search [m]; 0: no self-contact
    share: float  # of the room to a neighbour that a vertex may use
    seen: wp.array(dtype=wp.vec3)  # (v,) positions at the last search [m]
    safe: wp.array(dtype=float)  # (v,) `share` of the distance to the nearest neighbour then [m]
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
def link(touches: Touches, record: int):
    """Hang a record into the lists of its vertices."""
    vertex = touches.vertex[record]
    for slot in range(4):
        if vertex[slot] >= 0:
            item = 4 * record + slot
            touches.after[item] = wp.atomic_exch(touches.head, vertex[slot], item)


@wp.func
def push(touches: Touches, now: Iterate, step: StepNumbers, record: int):
    """Force [N] and block [N/m] at the point of a record: penalty, damping of approach, regularised Coulomb friction.

    Friction follows mu N (2 s - s^2) with s = slip speed / `friction_speed` up to 1 (Li et al. 2020, eq. 13).
    """
    normal = touches.normal[record]
    point = point_of(touches.vertex[record], touches.weight[record], now.x)
    depth = touches.offset[record] - wp.dot(normal, point)
    force = wp.vec3(0.0)
    block = wp.mat33(0.0)
    if depth > 0.0:
        along = wp.outer(normal, normal)
        stiffness = touches.stiffness[record]
        load = stiffness * depth
        moved = point - touches.anchor[record]
        approach = wp.dot(normal, moved)
        if approach < 0.0:
            damping = touches.damping[record] / step.dt
            load -= damping * approach
            stiffness += damping
        force = load * normal
        block = stiffness * along
        slip = moved - approach * normal
        distance = wp.length(slip)
        smooth = step.friction_speed * step.dt
        ratio = float(0.0)
        if distance > smooth:
            ratio = 1.0 / distance
        else:
            ratio = (2.0 - distance / smooth) / smooth
        grip = touches.friction[record] * load * ratio
        force -= grip * slip
        block += grip * (wp.identity(n=3, dtype=float) - along)
    return force, block


@wp.func
def hold_apart(touches: Touches, guard: Guard, v: int, wanted: wp.vec3):
    """Where a vertex may go on its way to `wanted`: no further than the search looked, and on its side of every plane.

    Moves below `safe`, the paper's bound beta min(r, d_tri, d_edge), need no look at the planes. The paper cuts every longer
    move to it, which locks layers that slide or part; only what leads through a dividing plane is cut here.
    """
    start = guard.seen[v]
    size = wp.length(wanted - start)
    if size <= guard.safe[v]:
        return wanted
    share = guard.share
    fraction = wp.min(1.0, share * guard.reach / size)
    node = int(touches.head[v])
    while node >= 0:
        record = node / 4
        plane = touches.plane[record]
        side = float(1.0)
        if node % 4 >= touches.first_side[record]:
            side = -1.0
        normal = side * wp.vec3(plane[0], plane[1], plane[2])
        room = wp.dot(normal, start) - side * plane[3]
        ahead = -wp.dot(normal, wanted - start)
        if ahead > share * room:
            fraction = wp.min(fraction, wp.max(share * room / ahead, 0.0))
        node = int(touches.after[node])
    if fraction < 1.0:
        wp.atomic_add(guard.cut, 0, 1)
    return start + fraction * (wanted - start)
