"""Every world brought to rest before it moves."""

import numpy as np

from sim1.cloth.precise.arrays import TABLE_Z
from sim1.cloth.precise.newton import net_width, newton
from sim1.cloth.precise.twins import FARTHEST_M, answers, matrix, solved

RESTING_M = 5e-5  # while rest is sought, friction is regularised below this displacement in a step: what lies stays where it lies


def rest(x, net, cloth, paths, held_on, tolerance, goals, *, rounds=8, most=600):
    """Bring every world to rest, in place: `x` (P, V, 3), held at `paths` (P, H, 3) where `held_on` (H,), pulled to `goals` (P, M, 3).

    Returns whether the base came to rest: nothing accelerates by more than `tolerance` [m/s^2].
    Implicit Euler with a growing step and no velocity carried along: energy only falls. Twins follow with the base's factor.
    """
    count, size, stencils = x.shape[0], x.shape[1], len(net.first) - 1
    band = np.empty((3 * size, 3 * net_width(net) + 3))
    out, force, nothing = np.empty((size, 3)), np.empty((len(net.marker_node), 3)), np.zeros((stencils, 3))
    goal, still = goals[0], np.zeros(goals.shape)
    h, done, base = 0.004, False, x[0]
    rubs = not np.isnan(cloth.scalar[0, TABLE_Z])
    for _ in range(most):
        before = base.copy()
        last = newton(
            base, -before / h, -before / (h * h), 1.0 / h, 1.0 / (h * h), RESTING_M / h, net, cloth,
            nothing, nothing, nothing, paths[0], held_on, 1e-7, 8, goal, still[0], band, out, force,
        )  # fmt: skip
        if last == -np.inf:
            base[:] = before
            h *= 0.25
            if h < 1e-6:
                return False
            continue
        moved = np.abs(base - before).max()
        creeps = rubs and h > 0.9 and moved < 1.5 * RESTING_M  # all that is left is what regularised friction lets pass
        if creeps or (-last < 1e-7 and moved < max(tolerance * h * h, 2e-7) and moved < 1e-5 and h > 0.05):
            done = True
            break
        # An inexact step still goes down; a very inexact one says that the next had better be shorter.
        h = min(h * 1.5, 1.0) if -last < 0.05 * moved else max(h * 0.6, 1e-4)
    if not done:
        return False
    if count > 1:
        h = 1.0
        for _ in range(3):  # twins are told from the base: what it still lacks to rest would count as their answer
            before = base.copy()
            newton(
                base, -before / h, -before / (h * h), 1.0 / h, 1.0 / (h * h), RESTING_M / h, net, cloth,
                nothing, nothing, nothing, paths[0], held_on, 1e-11, 20, goal, still[0], band, out, force,
            )  # fmt: skip
        full, pivot = np.empty((3 * size, 3 * (band.shape[1] - 1) + 1)), np.empty(3 * size, np.int32)
        kind = matrix(
            base, -base / h, 1.0 / h, 1.0 / (h * h), RESTING_M / h, net, cloth, nothing, nothing, held_on, goal,
            band, full, pivot,
        )  # fmt: skip
        if kind < 0:
            return False
        x[1:] = base
        right, nothings = np.empty((count - 1, size, 3)), np.zeros((count, stencils, 3))
        before = x.copy()
        for number in range(rounds):
            answers(
                x, -before / h, -before / (h * h), 1.0 / h, 1.0 / (h * h), RESTING_M / h, net, cloth,
                nothings, nothings, nothings, paths, held_on, goals, still, right,
            )  # fmt: skip
            solved(kind, band, full, pivot, net, cloth, held_on, right)
            x[1:] -= right
            if number % 2:
                before[1:] = x[1:]
        astray = ~(np.abs(x - base).max((1, 2)) < FARTHEST_M * 50)  # it rests elsewhere: tells nothing of the start
        x[astray] = base
    return True
