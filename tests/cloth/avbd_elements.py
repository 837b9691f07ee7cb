"""Force and Hessian block of single elements, as the solver's own functions give them, and the energies in float64."""

from typing import Any

import numpy as np
import warp as wp
from avbd_sheets import DEVICE, Run

from sim1.cloth.avbd.buffers import packed
from sim1.cloth.avbd.elastic import hinge, limit, membrane, refresh_hinge
from sim1.cloth.avbd.iterate import Iterate, StepNumbers
from sim1.cloth.avbd.sheet import Part, Sheet, parts_of


@wp.kernel(enable_backward=False)
def _membranes(
    parts: wp.array2d(dtype=Part),
    sheet: wp.array(dtype=Sheet),
    now: wp.array(dtype=Iterate),
    step: StepNumbers,
    force: wp.array2d(dtype=wp.vec3),
    block: wp.array2d(dtype=wp.mat33),
):
    t, corner = wp.tid()
    f, h = membrane(parts[t, corner], sheet[0].slack, sheet[0].growth, now, step)
    force[t, corner] = f
    block[t, corner] = h


@wp.kernel(enable_backward=False)
def _hinges(
    sheet: wp.array(dtype=Sheet),
    now: wp.array(dtype=Iterate),
    step: StepNumbers,
    force: wp.array2d(dtype=wp.vec3),
    block: wp.array2d(dtype=wp.mat33),
):
    h = wp.tid()
    refresh_hinge(sheet, now, step, h)
    for corner in range(4):
        f, b = hinge(now, h, corner)
        force[h, corner] = f
        block[h, corner] = b


@wp.kernel(enable_backward=False)
def _limits(
    sheet: wp.array(dtype=Sheet),
    now: wp.array(dtype=Iterate),
    step: StepNumbers,
    force: wp.array2d(dtype=wp.vec3),
    block: wp.array2d(dtype=wp.mat33),
):
    e, corner = wp.tid()
    ends = sheet[0].edge[e]
    f, h = limit(now, e, now[0].x[ends[corner]], now[0].x[ends[1 - corner]])
    force[e, corner] = f
    block[e, corner] = h


class Elements:
    """Elements of one kind of a model, by the solver's functions; `corners` (n, k) are their vertices."""

    def __init__(self, kind: str, run: Run, largest_strain: float = 0.05) -> None:
        self.solver = run.solver
        sheet = self.solver.sheet
        kernel, source, both = {
            "membrane": (_membranes, sheet.triangle, True),
            "hinge": (_hinges, sheet.hinge, False),
            "limit": (_limits, sheet.edge, True),
        }[kind]
        self.corners = source.numpy().astype(int)
        self._kernel = kernel
        self._parts = [_corner_parts(sheet)] if kind == "membrane" else []
        self._dim = self.corners.shape if both else (len(self.corners),)
        self._step = StepNumbers()
        self.solver.now.edge_free.assign((1.0 + largest_strain) * sheet.edge_length.numpy())

    def at(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Forces (n, k, 3) and blocks (n, k, 3, 3)."""
        now: Any = self.solver.now
        now.x.assign(np.ascontiguousarray(x, dtype=np.float32))
        force = wp.zeros(self.corners.shape, dtype=wp.vec3, device=DEVICE)
        block = wp.zeros(self.corners.shape, dtype=wp.mat33, device=DEVICE)
        inputs = [*self._parts, packed(self.solver.sheet, Sheet), packed(now, Iterate), self._step, force, block]
        wp.launch(self._kernel, dim=self._dim, inputs=inputs, device=DEVICE)
        return force.numpy().astype(float), block.numpy().astype(float)


def _corner_parts(sheet: Sheet) -> wp.array:
    """Every triangle as each of its corners alone sees it, (t, 3)."""
    pose = sheet.triangle_pose.numpy()
    slopes = np.stack([-(pose[:, 0] + pose[:, 1]), pose[:, 0], pose[:, 1]], axis=1)
    return parts_of(sheet, np.repeat(np.arange(len(pose)), 3), slopes.reshape(-1, 2)).reshape((-1, 3))


def membrane_energy(x: np.ndarray, rest: np.ndarray, mu: float, lam: float) -> float:
    """St. Venant-Kirchhoff energy [J] of one triangle (3, 3) with rest corners (3, 3), from edge lengths alone."""
    metric_rest, metric = (np.array([[a @ b for b in e] for a in e]) for e in (_sides(rest), _sides(x)))
    mixed = np.linalg.solve(metric_rest, 0.5 * (metric - metric_rest))  # Green strain with one index raised
    area = 0.5 * np.sqrt(np.linalg.det(metric_rest))
    return float(area * (mu * np.trace(mixed @ mixed) + 0.5 * lam * np.trace(mixed) ** 2))


def woven_energy(x: np.ndarray, rest: np.ndarray, law: np.ndarray, share: float, growth: float) -> float:
    """Energy [J] of one triangle (3, 3) of a `law` (3, 3) along x and y, in which it lies at rest.

    `share` of the law's own, the rest what is least of it when wrinkles may add any strain that is not negative; and
    C e^3 growth / 3 along each axis where it is pulled.
    """
    gradient = np.linalg.solve(_sides(rest)[:, :2], _sides(x)).T  # (3, 2)
    green = 0.5 * (gradient.T @ gradient - np.eye(2))
    strain = np.array([green[0, 0], green[1, 1], 2.0 * green[0, 1]])
    full = 0.5 * strain @ law @ strain
    pulled = np.maximum(strain[:2], 0.0)
    grown = growth / 3.0 * (np.diag(law)[:2] * pulled**3).sum()
    area = 0.5 * np.linalg.norm(np.cross(*_sides(rest)))
    return float(area * (share * full + (1.0 - share) * (full - _saved(green, strain, law)) + grown))


def _saved(green: np.ndarray, strain: np.ndarray, law: np.ndarray) -> float:
    """By how much wrinkles of the best direction lower the energy of a strain."""
    if np.linalg.eigvalsh(green).max() <= 0.0:
        return float(0.5 * strain @ law @ strain)

    def gain(angle: np.ndarray) -> np.ndarray:
        across = np.stack([np.cos(angle) ** 2, np.sin(angle) ** 2, np.sin(2.0 * angle)], axis=-1)
        return 0.5 * np.maximum(-across @ law @ strain, 0.0) ** 2 / np.einsum("...i,ij,...j", across, law, across)

    middle, wide = 0.0, np.pi
    for _ in range(12):
        angles = middle + 0.5 * wide * np.linspace(-1.0, 1.0, 41)
        middle, wide = angles[np.argmax(gain(angles))], 0.1 * wide
    return float(gain(np.array(middle)))


def _sides(corners: np.ndarray) -> np.ndarray:
    return np.stack([corners[1] - corners[0], corners[2] - corners[0]])


def fold_angle(x: np.ndarray) -> float:
    """Angle [rad] between the normals of triangles (0, 2, 3) and (1, 3, 2), positive where the normals turn along 2 -> 3."""
    a, b, c, d = x
    first, second = np.cross(c - a, d - a), np.cross(d - b, c - b)
    along = (d - c) / np.linalg.norm(d - c)
    return float(np.arctan2(np.cross(first, second) @ along, first @ second))


def downhill(energy: Any, x: np.ndarray, by: float = 1e-6) -> np.ndarray:
    """Minus the gradient of `energy` at corners (k, 3), by central differences."""
    force = np.zeros_like(x)
    for index in np.ndindex(x.shape):
        for sign in (1.0, -1.0):
            moved = x.copy()
            moved[index] += sign * by
            force[index] -= sign * energy(moved) / (2.0 * by)
    return force
