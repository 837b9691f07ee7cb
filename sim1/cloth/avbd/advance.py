"""Beginning and end of a step: inertia, guess, histories for rates, decay of the multipliers, velocities.

A rate is written as `rate * value - past`. Implicit Euler: (value - last) / dt. BDF2: (3 value - 4 last + one before) / (2 dt);
positions and velocities then follow x = (4 x1 - x2) / 3 + (2 dt / 3) v and v = (4 v1 - v2) / 3 + (2 dt / 3) a.
"""

import newton
import warp as wp

from sim1.cloth.avbd.elastic import bend, frame, green_strain
from sim1.cloth.avbd.iterate import Iterate
from sim1.cloth.avbd.sheet import Sheet
from sim1.cloth.avbd.touch import Touches

ACTIVE = wp.constant(wp.int32(int(newton.ParticleFlags.ACTIVE)))


@wp.kernel(enable_backward=False)
def begin_step(
    sheet: Sheet,
    now: Iterate,
    second_order: int,
    dt: float,
    position: wp.array(dtype=wp.vec3),
    speed: wp.array(dtype=wp.vec3),
    load: wp.array(dtype=wp.vec3),
    inverse_mass: wp.array(dtype=float),
    flags: wp.array(dtype=wp.int32),
    gravity: wp.array(dtype=wp.vec3),
    world: wp.array(dtype=wp.int32),
):
    """Take over a state, and where inertia, gravity and given loads alone would carry each vertex."""
    v = wp.tid()
    at = position[v]
    now.fresh[v] = 0
    if not (wp.length(at - now.x[v]) == 0.0):  # put there from outside, or the first step: no history
        now.fresh[v] = 1  # its step is one of implicit Euler: BDF2 would take its acceleration so far for zero
        now.before[v] = at - dt * speed[v]
        now.before_speed[v] = speed[v]
    now.start[v] = at
    now.x[v] = at
    now.expected[v] = speed[v]
    if second_order != 0:
        now.expected[v] = 2.0 * speed[v] - now.before_speed[v]
    now.force[v] = wp.vec3(0.0)
    now.slope[v] = wp.mat33(0.0)
    movable = wp.int32(0)
    if (flags[v] & ACTIVE) != 0 and inverse_mass[v] > 0.0:
        movable = wp.int32(1)
    sheet.movable[v] = movable
    pull = gravity[wp.max(world[v], 0)] + load[v] * inverse_mass[v]
    if second_order != 0 and now.fresh[v] == 0:
        now.target[v] = (
            at
            + (at - now.before[v]) / 3.0
            + (2.0 * dt / 3.0) * (4.0 * speed[v] - now.before_speed[v]) / 3.0
            + (4.0 * dt * dt / 9.0) * pull
        )
    else:
        now.target[v] = at + dt * speed[v] + dt * dt * pull
    if movable == 0:
        now.target[v] = at


@wp.kernel(enable_backward=False)
def guess(
    sheet: Sheet,
    now: Iterate,
    solids: Touches,
    free: int,
    dt: float,
    keep: float,
    speed: wp.array(dtype=wp.vec3),
    gravity: wp.array(dtype=wp.vec3),
    world: wp.array(dtype=wp.int32),
):
    """Wish to start from the last velocity and as much of gravity as acted in the last step (VBD, Chen et al. 2024).

    `free`: nothing is in the way, the wish is fulfilled at once.
    """
    v = wp.tid()
    at = now.start[v]
    if sheet.movable[v] != 0:
        down = gravity[wp.max(world[v], 0)]
        strength = wp.dot(down, down)
        felt = float(0.0)
        if strength > 0.0:
            felt = wp.clamp(wp.dot(speed[v] - now.before_speed[v], down) / strength, 0.0, dt * keep)
            if now.fresh[v] != 0 and solids.head[v] < 0:
                felt = dt * wp.min(keep, 1.0)  # nothing known of it yet: free fall, unless it lies on something
        at = at + dt * (speed[v] + felt * down)
    now.wish[v] = at
    if free != 0:
        now.x[v] = at


@wp.kernel(enable_backward=False)
def begin_elements(
    sheet: Sheet,
    now: Iterate,
    second_order: int,
    dt: float,
    limit: float,
    first_stiffness: float,
    force_decay: float,
    stiffness_decay: float,
):
    """Histories of strain and angle, and the decay of the strain limit's multipliers."""
    i = wp.tid()
    if i < sheet.triangle.shape[0]:
        if sheet.triangle_viscosity[i] > 0.0:
            f1, f2 = frame(sheet, now.start, i)
            past = green_strain(f1, f2) / dt
            if second_order != 0:
                g1, g2 = frame(sheet, now.before, i)
                past = 2.0 * past - green_strain(g1, g2) / (2.0 * dt)
            now.triangle_past[i] = past
    if i < sheet.hinge.shape[0]:
        v = sheet.hinge[i]
        turn = 6.283185307179586
        angle, _a, _b, _c, _d = bend(now.start[v[0]], now.start[v[1]], now.start[v[2]], now.start[v[3]])
        angle += turn * wp.round((now.hinge_now[i] - angle) / turn)
        now.hinge_now[i] = angle
        if sheet.hinge_damping[i] > 0.0:
            past_angle = angle / dt
            if second_order != 0:
                older, _e, _f, _g, _h = bend(now.before[v[0]], now.before[v[1]], now.before[v[2]], now.before[v[3]])
                older += turn * wp.round((angle - older) / turn)
                past_angle = 2.0 * past_angle - older / (2.0 * dt)
            now.hinge_past[i] = past_angle
    if i < sheet.edge.shape[0]:
        ends = sheet.edge[i]
        excess = wp.length(now.start[ends[0]] - now.start[ends[1]]) - limit * sheet.edge_length[i]
        now.edge_excess[i] = wp.max(excess, 0.0)
        now.edge_force[i] = force_decay * now.edge_force[i]
        now.edge_stiffness[i] = wp.max(first_stiffness, stiffness_decay * now.edge_stiffness[i])


@wp.kernel(enable_backward=False)
def end_step(
    sheet: Sheet,
    now: Iterate,
    second_order: int,
    dt: float,
    speed: wp.array(dtype=wp.vec3),
    position_out: wp.array(dtype=wp.vec3),
    speed_out: wp.array(dtype=wp.vec3),
):
    """Velocities from the positions, and the history of the next step."""
    v = wp.tid()
    at = now.x[v]
    start = now.start[v]
    was = speed[v]
    if sheet.movable[v] != 0:
        if second_order != 0 and now.fresh[v] == 0:
            speed_out[v] = (3.0 * (at - start) - (start - now.before[v])) / (2.0 * dt)
        else:
            speed_out[v] = (at - start) / dt
    else:
        speed_out[v] = was
    position_out[v] = at
    now.before[v] = start
    now.before_speed[v] = was
