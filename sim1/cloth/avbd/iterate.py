"""What changes during a step: positions, history, multipliers."""

import warp as wp


@wp.struct
class Iterate:
    """Unknowns of a step and what it was started from."""

    x: wp.array(dtype=wp.vec3)  # (v,) [m]
    target: wp.array(dtype=wp.vec3)  # (v,) where inertia alone would take the vertex [m]
    start: wp.array(dtype=wp.vec3)  # (v,) at the beginning of the step [m]
    before: wp.array(dtype=wp.vec3)  # (v,) one step earlier [m]
    before_speed: wp.array(dtype=wp.vec3)  # (v,) one step earlier [m/s]
    expected: wp.array(dtype=wp.vec3)  # (v,) velocity that the step is expected to end with [m/s]
    wish: wp.array(dtype=wp.vec3)  # (v,) where the sweeps should start [m]
    fresh: wp.array(dtype=wp.int32)  # (v,) 1: without history in this step
    triangle_past: wp.array(dtype=wp.vec3)  # (t,) rate of strain = rate * G - past, Voigt [1/s]
    hinge_now: wp.array(dtype=float)  # (h,) angle when last looked at [rad]
    hinge_moment: wp.array(
        dtype=float
    )  # (h,) over the root of its change with the angle, kept up to date as vertices move [sqrt(N m)]
    hinge_past: wp.array(dtype=float)  # (h,) rate of angle = rate * angle - past [rad/s]
    hinge_slope: wp.array2d(dtype=wp.vec3)  # (h, 4) change of the angle with its vertices times that root [sqrt(N m)/m]
    edge_force: wp.array(dtype=float)  # (e,) multiplier [N]
    edge_stiffness: wp.array(dtype=float)  # (e,) penalty [N/m]
    edge_free: wp.array(
        dtype=float
    )  # (e,) length that the step leaves it: (1 + xi) l0 + alpha times the violation at its beginning [m]
    force: wp.array(dtype=wp.vec3)  # (v,) of effects, if the vertex stayed at `start` [N]
    slope: wp.array(dtype=wp.mat33)  # (v,) minus its derivative over the position, positive semi-definite [N/m]
    broken: wp.array(dtype=wp.int32)  # (3,) vertex + 1, term, step of the first value that is not finite


@wp.struct
class StepNumbers:
    """Scalars of a step."""

    inertia: float  # mass times this is the stiffness of inertia [1/s^2]
    rate: float  # d/dt is rate * value - past [1/s]
    dt: float  # [s]
    step: wp.int32
    edge_stiffness_max: float  # [N/m]
    edge_growth: float  # [N/m per m]
    edge_share: float  # of a multiplier's step that is taken
    friction_speed: float  # [m/s]
