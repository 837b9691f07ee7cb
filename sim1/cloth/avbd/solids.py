"""Contact of the cloth with newton's shapes: records from the collision pipeline's soft contacts, and what pushes back."""

import newton
import warp as wp

from sim1.cloth.avbd.iterate import Iterate, StepNumbers
from sim1.cloth.avbd.touch import Touches, link, point_of, push

KINEMATIC = wp.constant(wp.int32(int(newton.BodyFlags.KINEMATIC)))


@wp.kernel(enable_backward=False)
def collect_solids(
    contact_count: wp.array(dtype=wp.int32),
    corners: wp.array(dtype=wp.vec3i),
    share: wp.array(dtype=wp.vec3),
    shape: wp.array(dtype=wp.int32),
    place: wp.array(dtype=wp.vec3),
    drift: wp.array(dtype=wp.vec3),
    normal: wp.array(dtype=wp.vec3),
    shape_body: wp.array(dtype=wp.int32),
    shape_margin: wp.array(dtype=float),
    stiffness: wp.array(dtype=float),
    damping: wp.array(dtype=float),
    friction: wp.array(dtype=float),
    radius: wp.array(dtype=float),
    body_then: wp.array(dtype=wp.transform),
    body_now: wp.array(dtype=wp.transform),
    dt: float,
    now: wp.array(dtype=Iterate),
    solids: wp.array(dtype=Touches),
):
    """Material is the shape's own: its values are of the pair with cloth, as in the paper's table, not mixed again."""
    c = wp.tid()
    if c < wp.min(contact_count[0], solids[0].capacity):
        s = shape[c]
        body = shape_body[s]
        before = wp.transform_identity()
        after = wp.transform_identity()
        if body >= 0:
            before = body_then[body]
            after = body_now[body]
        point = wp.transform_point(after, place[c])
        carried = point - wp.transform_point(before, place[c]) + dt * wp.transform_vector(after, drift[c])
        corner = corners[c]
        vertex = wp.vec4i(corner[0], corner[1], corner[2], -1)
        weight = wp.vec4(share[c][0], share[c][1], share[c][2], 0.0)
        thick = radius[corner[0]]
        if corner[1] >= 0:
            thick = wp.max(thick, radius[corner[1]])
        if corner[2] >= 0:
            thick = wp.max(thick, radius[corner[2]])
        solids[0].vertex[c] = vertex
        solids[0].weight[c] = weight
        solids[0].normal[c] = normal[c]
        solids[0].offset[c] = wp.dot(normal[c], point) + thick + shape_margin[s]
        solids[0].anchor[c] = point_of(vertex, weight, now[0].start) + carried
        solids[0].stiffness[c] = stiffness[s]
        solids[0].damping[c] = damping[s]
        solids[0].friction[c] = friction[s]
        solids[0].skew[c] = 0.0
        solids[0].shape[c] = s
        link(vertex, c, solids[0].head, solids[0].after)


@wp.kernel(enable_backward=False)
def push_back(
    now: wp.array(dtype=Iterate),
    step: StepNumbers,
    solids: wp.array(dtype=Touches),
    contact_count: wp.array(dtype=wp.int32),
    shape_body: wp.array(dtype=wp.int32),
    body_q: wp.array(dtype=wp.transform),
    body_com: wp.array(dtype=wp.vec3),
    wrench: wp.array(dtype=wp.spatial_vector),
):
    """What the cloth does to the bodies: force [N] and torque about the centre of mass [N m], world frame."""
    c = wp.tid()
    if c < wp.min(contact_count[0], solids[0].capacity):
        body = shape_body[solids[0].shape[c]]
        if body >= 0:
            force, _block = push(solids, now, step, c, wp.vec3(0.0))
            point = point_of(solids[0].vertex[c], solids[0].weight[c], now[0].x)
            centre = wp.transform_point(body_q[body], body_com[body])
            wp.atomic_add(wrench, body, wp.spatial_vector(-force, wp.cross(point - centre, -force)))


@wp.kernel(enable_backward=False)
def load_bodies(
    given: wp.array(dtype=wp.spatial_vector),
    cloth: wp.array(dtype=wp.spatial_vector),
    load: wp.array(dtype=wp.spatial_vector),
):
    """Forces on bodies: those of the state and the cloth's of the last step."""
    body = wp.tid()
    load[body] = given[body] + cloth[body]


@wp.kernel(enable_backward=False)
def take_dynamic(
    inverse_mass: wp.array(dtype=float),
    flags: wp.array(dtype=wp.int32),
    pose: wp.array(dtype=wp.transform),
    speed: wp.array(dtype=wp.spatial_vector),
    pose_out: wp.array(dtype=wp.transform),
    speed_out: wp.array(dtype=wp.spatial_vector),
):
    """Poses of the bodies that move by themselves; kinematic ones stay where the caller has put them."""
    body = wp.tid()
    if inverse_mass[body] > 0.0 and (flags[body] & KINEMATIC) == 0:
        pose_out[body] = pose[body]
        speed_out[body] = speed[body]
