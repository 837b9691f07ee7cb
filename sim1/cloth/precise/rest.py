"""Every world brought to rest before it moves."""

import numpy as np

from sim1.cloth.precise.arrays import RETAINED, TABLE_Z
from sim1.cloth.precise.memory import curvatures, fold
from sim1.cloth.precise.newton import net_width, newton
from sim1.cloth.precise.twins import FARTHEST_M, answers, matrix, solved

FOLDS_1_M = 0.02  # what folds keep changes no more than this where a sheet rests
FOLDINGS = 60  # times that a sheet finds its rest with what folds have kept so far
FIRST_S = 0.004  # the first step of the search for rest
RESTING_M = 5e-5  # while rest is sought, friction is regularised below this displacement in a step: what lies stays where it lies


def rest(x, net, cloth, paths, held_on, tolerance, goals, *, rounds=8, most=600):
    """Bring every world to rest, in place: `x` (P, V, 3), held at `paths` (P, H, 3) where `held_on` (H,), pulled to `goals` (P, M, 3).

    Returns whether the base came to rest: nothing accelerates by more than `tolerance` [m/s^2].
    Implicit Euler with a growing step and no velocity carried along: energy only falls. Twins follow with the base's factor.
    Where folds keep what bends them, rest and folds are sought in turn, from a flat sheet that is bent once.
    """
    count, size, stencils = x.shape[0], x.shape[1], len(net.first) - 1
    band = np.empty((3 * size, 3 * net_width(net) + 3))
    out, force, nothing = np.empty((size, 3)), np.empty((len(net.marker_node), 3)), np.zeros((stencils, 3))
    goal, still = goals[0], np.zeros(goals.shape)
    crease, bent, base = np.zeros((count, stencils, 6)), np.zeros((stencils, 3)), x[0]
    for folding in range(FOLDINGS):
        start_s = FIRST_S if folding == 0 else 0.1
        if not _settled(
            base, net, cloth, crease[0], paths[0], held_on, tolerance, goal, still[0], band, out, force, start_s, most
        ):  # fmt: skip
            return False
        if cloth.scalar[0, RETAINED] == 0.0:
            break
        curvatures(base, net, bent)
        before = crease[0].copy()
        crease[0] = 0.0
        fold(bent, cloth.scalar[0], crease[0])
        if np.abs(crease[0] - before).max() < FOLDS_1_M:
            break
    else:
        return False
    if count > 1:
        h = 1.0
        for _ in range(3):  # twins are told from the base: what it still lacks to rest would count as their answer
            before = base.copy()
            newton(
                base, -before / h, -before / (h * h), 1.0 / h, 1.0 / (h * h), RESTING_M / h, net, cloth,
                nothing, nothing, crease[0], paths[0], held_on, 1e-11, 20, goal, still[0], False, band, out, force,
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
            for p in range(1, count):
                if cloth.scalar[p, RETAINED] != 0.0:
                    curvatures(x[p], net, bent)
                    crease[p] = 0.0
                    fold(bent, cloth.scalar[p], crease[p])
            answers(
                x, -before / h, -before / (h * h), 1.0 / h, 1.0 / (h * h), RESTING_M / h, net, cloth,
                nothings, nothings, crease, paths, held_on, goals, still, right,
            )  # fmt: skip
            solved(kind, band, full, pivot, net, cloth, held_on, right)
            x[1:] -= right
            if number % 2:
                before[1:] = x[1:]
        astray = ~(np.abs(x - base).max((1, 2)) < FARTHEST_M * 50)  # it rests elsewhere: tells nothing of the start
        x[astray] = base
    return True


def _settled(base, net, cloth, crease, path, held_on, tolerance, goal, still, band, out, force, h, most):
    """Bring `base` (V, 3) to rest in place, with what folds have kept held; implicit Euler, first with a step of `h` seconds."""
    rubs = not np.isnan(cloth.scalar[0, TABLE_Z])
    nothing = np.zeros((len(crease), 3))
    for _ in range(most):
        before = base.copy()
        last = newton(
            base, -before / h, -before / (h * h), 1.0 / h, 1.0 / (h * h), RESTING_M / h, net, cloth,
            nothing, nothing, crease, path, held_on, 1e-7, 8, goal, still, False, band, out, force,
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
            return True
        # An inexact step still goes down; a very inexact one says that the next had better be shorter.
        h = min(h * 1.5, 1.0) if -last < 0.05 * moved else max(h * 0.6, 1e-4)
    return False
