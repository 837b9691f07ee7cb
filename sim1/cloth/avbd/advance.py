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
    sheet: wp.array(dtype=Sheet),
    now: wp.array(dtype=Iterate),
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
    now[0].fresh[v] = 0
    if not (wp.length(at - now[0].x[v]) == 0.0):  # put there from outside, or the first step: no history
        now[0].fresh[v] = 1  # its step is one of implicit Euler: BDF2 would take its acceleration so far for zero
        now[0].before[v] = at - dt * speed[v]
        now[0].before_speed[v] = speed[v]
    now[0].start[v] = at
    now[0].x[v] = at
    now[0].expected[v] = speed[v]
    if second_order != 0:
        now[0].expected[v] = 2.0 * speed[v] - now[0].before_speed[v]
    now[0].force[v] = wp.vec3(0.0)
    now[0].slope[v] = wp.mat33(0.0)
    movable = wp.int32(0)
    if (flags[v] & ACTIVE) != 0 and inverse_mass[v] > 0.0:
        movable = wp.int32(1)
    sheet[0].movable[v] = movable
    pull = gravity[wp.max(world[v], 0)] + load[v] * inverse_mass[v]
    if second_order != 0 and now[0].fresh[v] == 0:
        now[0].target[v] = (
            at
            + (at - now[0].before[v]) / 3.0
            + (2.0 * dt / 3.0) * (4.0 * speed[v] - now[0].before_speed[v]) / 3.0
            + (4.0 * dt * dt / 9.0) * pull
        )
    else:
        now[0].target[v] = at + dt * speed[v] + dt * dt * pull
    if movable == 0:
        now[0].target[v] = at


@wp.kernel(enable_backward=False)
def guess(
    sheet: wp.array(dtype=Sheet),
    now: wp.array(dtype=Iterate),
    solids: wp.array(dtype=Touches),
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
    at = now[0].start[v]
    if sheet[0].movable[v] != 0:
        down = gravity[wp.max(world[v], 0)]
        strength = wp.dot(down, down)
        felt = float(0.0)
        if strength > 0.0:
            felt = wp.clamp(wp.dot(speed[v] - now[0].before_speed[v], down) / strength, 0.0, dt * keep)
            if now[0].fresh[v] != 0 and solids[0].head[v] < 0:
                felt = dt * wp.min(keep, 1.0)  # nothing known of it yet: free fall, unless it lies on something
        at = at + dt * (speed[v] + felt * down)
    now[0].wish[v] = at
    if free != 0:
        now[0].x[v] = at


@wp.kernel(enable_backward=False)
def begin_elements(
    sheet: wp.array(dtype=Sheet),
    now: wp.array(dtype=Iterate),
    second_order: int,
    dt: float,
    limit: float,
    regularization: float,
    first_stiffness: float,
    force_decay: float,
    stiffness_decay: float,
):
    """Histories of strain and angle, and the decay of the strain limit's multipliers."""
    i = wp.tid()
    if i < sheet[0].triangle.shape[0]:
        if sheet[0].triangle_viscosity[i] > 0.0:
            f1, f2 = frame(sheet[0].triangle[i], sheet[0].triangle_pose[i], now[0].start)
            past = green_strain(f1, f2) / dt
            if second_order != 0:
                g1, g2 = frame(sheet[0].triangle[i], sheet[0].triangle_pose[i], now[0].before)
                past = 2.0 * past - green_strain(g1, g2) / (2.0 * dt)
            now[0].triangle_past[i] = past
    if i < sheet[0].hinge.shape[0]:
        v = sheet[0].hinge[i]
        turn = 6.283185307179586
        angle, _a, _b, _c, _d = bend(now[0].start[v[0]], now[0].start[v[1]], now[0].start[v[2]], now[0].start[v[3]])
        angle += turn * wp.round((now[0].hinge_now[i] - angle) / turn)
        now[0].hinge_now[i] = angle
        if sheet[0].hinge_damping[i] > 0.0:
            past_angle = angle / dt
            if second_order != 0:
                older, _e, _f, _g, _h = bend(
                    now[0].before[v[0]], now[0].before[v[1]], now[0].before[v[2]], now[0].before[v[3]]
                )
                older += turn * wp.round((angle - older) / turn)
                past_angle = 2.0 * past_angle - older / (2.0 * dt)
            now[0].hinge_past[i] = past_angle
    if i < sheet[0].edge.shape[0]:
        ends = sheet[0].edge[i]
        free = limit * sheet[0].edge_length[i]
        excess = wp.length(now[0].start[ends[0]] - now[0].start[ends[1]]) - free
        now[0].edge_free[i] = free + regularization * wp.max(excess, 0.0)
        now[0].edge_force[i] = force_decay * now[0].edge_force[i]
        now[0].edge_stiffness[i] = wp.max(first_stiffness, stiffness_decay * now[0].edge_stiffness[i])


@wp.kernel(enable_backward=False)
def end_step(
    sheet: wp.array(dtype=Sheet),
    now: wp.array(dtype=Iterate),
    second_order: int,
    dt: float,
    speed: wp.array(dtype=wp.vec3),
    position_out: wp.array(dtype=wp.vec3),
    speed_out: wp.array(dtype=wp.vec3),
):
    """Velocities from the positions, and the history of the next step."""
    v = wp.tid()
    at = now[0].x[v]
    start = now[0].start[v]
    was = speed[v]
    if sheet[0].movable[v] != 0:
        if second_order != 0 and now[0].fresh[v] == 0:
            speed_out[v] = (3.0 * (at - start) - (start - now[0].before[v])) / (2.0 * dt)
        else:
            speed_out[v] = (at - start) / dt
    else:
        speed_out[v] = was
    position_out[v] = at
    now[0].before[v] = start
    now[0].before_speed[v] = was
