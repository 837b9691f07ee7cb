"""Time integration of a held sheet: BDF2 with Newton's method on a banded matrix.

BDF2 is second order and does not feed numerical damping into slow swings: at 1 Hz and h = 1/60 s it loses 0.1 % a period, where implicit
Euler loses a third. Held vertices follow given paths exactly and are no unknowns.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from sim1.mismatch.sheet import Material, Sheet, deformation, green_strain, plane_stress


class NotConverged(RuntimeError):
    """Newton's method found no next state: step too large for this material, or a jump of the held vertices."""


@dataclass(frozen=True, kw_only=True)
class _Layout:
    """Where the entries of element matrices lie in the band of the free vertices' matrix."""

    free: np.ndarray  # (n,) vertices that move by the equation of motion, in an order of small bandwidth
    width: int  # upper diagonals of the band
    slot: np.ndarray  # position in the flat band of each kept entry of the faces' 9 x 9 matrices
    entry: np.ndarray  # which entries of the flat (F, 9, 9) those are
    mass_slot: np.ndarray  # diagonal
    bending_slot: np.ndarray
    bending_value: np.ndarray
    bending: csr_array  # Q of the sheet


def _bandwidth(matrix: csr_array, order: np.ndarray) -> int:
    block = coo_array(matrix[order][:, order])
    return int(np.abs(block.row - block.col).max())


def _layout(sheet: Sheet, held: np.ndarray) -> _Layout:
    free = np.setdiff1d(np.arange(len(sheet.material_m)), held)
    bending = sheet.bending_matrix
    corners = (np.repeat(sheet.faces, 3, axis=1).ravel(), np.tile(sheet.faces, 3).ravel())
    coupled = (abs(bending) + coo_array((np.ones(9 * len(sheet.faces)), corners), bending.shape)).tocsr()
    other = free[reverse_cuthill_mckee(coupled[free][:, free].tocsr(), symmetric_mode=True)]
    free = min(free, other, key=lambda order: _bandwidth(coupled, order))
    place = np.full(len(sheet.material_m), -1)
    place[free] = np.arange(len(free))
    coo = coo_array(bending)
    width = 3 * _bandwidth(coupled, free) + 2
    size = 3 * len(free)

    def slots(row: np.ndarray, column: np.ndarray) -> np.ndarray:
        return (width + row - column) * size + column

    dof = np.where(place[sheet.faces] >= 0, 3 * place[sheet.faces], -9)[..., None] + np.arange(3)
    dof = dof.reshape(-1, 9)
    row, column = np.repeat(dof, 9, axis=1).ravel(), np.tile(dof, 9).ravel()
    kept = np.flatnonzero((row >= 0) & (column >= 0) & (row <= column))
    b_row, b_column = place[coo.row], place[coo.col]
    b_kept = (b_row >= 0) & (b_column >= 0) & (b_row <= b_column)
    b_slot = np.concatenate([slots(3 * b_row[b_kept] + k, 3 * b_column[b_kept] + k) for k in range(3)])
    every = np.arange(size)
    return _Layout(
        free=free,
        width=width,
        slot=slots(row[kept], column[kept]),
        entry=kept,
        mass_slot=slots(every, every),
        bending_slot=b_slot,
        bending_value=np.tile(coo.data[b_kept], 3),
        bending=bending,
    )


class HeldSheet:
    """A sheet with a fixed set of held vertices, ready to be stepped."""

    def __init__(self, sheet: Sheet, held: np.ndarray):
        self.sheet = sheet
        self.held = np.asarray(held, dtype=int)
        self._layout = _layout(sheet, self.held)

    def forces(self, material: Material, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Internal and air forces (V, 3) at shape `x` and velocity `v`, N."""
        return self._forces(material, x, v)[0]

    def _forces(self, material: Material, x: np.ndarray, v: np.ndarray):
        sheet, tau = self.sheet, material.damping_s
        F, rate = deformation(sheet, x), deformation(sheet, v)
        fu, fv, ru, rv = F[..., 0], F[..., 1], rate[..., 0], rate[..., 1]
        strain_rate = np.stack([(fu * ru).sum(-1), (fv * rv).sum(-1), (fu * rv + fv * ru).sum(-1)], axis=-1)
        stress = (green_strain(F) + tau * strain_rate) @ plane_stress(material)
        tensor = stress[:, [[0, 2], [2, 1]]]
        corner = -sheet.face_area_m2[:, None, None] * np.matmul(
            np.matmul(F, tensor), sheet.gradients.transpose(0, 2, 1)
        )
        corner = corner.transpose(0, 2, 1)  # (F, 3 corners, 3)
        drag = None
        if material.c_normal or material.c_tangential:
            pull, drag = _air(material, F, v[sheet.faces].mean(1), sheet.face_area_m2)
            corner = corner + pull[:, None] / 3
        force = -material.bending_n_m * (self._layout.bending @ (x + tau * v))
        for k in range(3):
            force[:, k] += np.bincount(sheet.faces.ravel(), corner[..., k].ravel(), minlength=len(x))
        return force, F, tensor, drag

    def _factor(self, material: Material, F, tensor, drag, mass_rate: float, velocity_rate: float, exact: bool):
        """Banded Cholesky factor of mass * mass_rate + stiffness + damping * velocity_rate."""
        sheet = self.sheet
        g, area = sheet.gradients, sheet.face_area_m2
        visco = 1 + material.damping_s * velocity_rate
        fu, fv = F[..., 0], F[..., 1]
        B = np.empty((len(g), 3, 3, 3))  # (F, strain, corner, axis)
        B[:, 0] = g[:, :, 0, None] * fu[:, None]
        B[:, 1] = g[:, :, 1, None] * fv[:, None]
        B[:, 2] = g[:, :, 0, None] * fv[:, None] + g[:, :, 1, None] * fu[:, None]
        B = B.reshape(-1, 3, 9)
        local = np.matmul((visco * area[:, None, None]) * np.matmul(B.transpose(0, 2, 1), plane_stress(material)), B)
        if drag is not None:
            local = local + np.tile(drag * (velocity_rate / 9), (1, 3, 3))
        if exact:
            try:
                return self._cholesky(material, local, tensor, mass_rate, visco)
            except LinAlgError:  # compressed faces make the exact matrix indefinite: keep their tension alone
                pass
        values, vectors = np.linalg.eigh(tensor)
        tension = np.matmul(vectors * np.clip(values, 0, None)[:, None], vectors.transpose(0, 2, 1))
        return self._cholesky(material, local, tension, mass_rate, visco)

    def _cholesky(self, material: Material, local, tensor, mass_rate: float, visco: float):
        """Factor of the matrix with the faces' own part `local` (F, 9, 9) and the geometric part of the stress `tensor`."""
        sheet, lay, g = self.sheet, self._layout, self.sheet.gradients
        weight = sheet.face_area_m2[:, None, None] * np.matmul(np.matmul(g, tensor), g.transpose(0, 2, 1))
        full = local.reshape(-1, 3, 3, 3, 3).copy()
        for k in range(3):
            full[:, :, k, :, k] += weight
        size = 3 * len(lay.free)
        band = np.bincount(lay.slot, full.ravel()[lay.entry], minlength=(lay.width + 1) * size)
        band += np.bincount(lay.bending_slot, material.bending_n_m * visco * lay.bending_value, minlength=len(band))
        mass = material.area_density_kg_m2 * sheet.vertex_area_m2[lay.free]
        band[lay.mass_slot] += np.repeat(mass * mass_rate, 3)
        return cholesky_banded(band.reshape(lay.width + 1, size), check_finite=False)

    def solve_step(self, material, x, history, gravity, mass_rate, velocity_rate, tolerance_m, most=40, exact=True):
        """Next shape from a guess `x`, in place: velocity = velocity_rate * x + history[0], acceleration likewise with mass_rate."""
        free = self._layout.free
        mass = material.area_density_kg_m2 * self.sheet.vertex_area_m2[free, None]
        for trial in range(most):
            v = velocity_rate * x + history[0]
            force, *state = self._forces(material, x, v)
            residual = force[free] + mass * (gravity - mass_rate * x[free] - history[1][free])
            factor = self._factor(material, *state, mass_rate, velocity_rate, exact=exact and trial < most // 2)
            change = cho_solve_banded((factor, False), residual.ravel(), check_finite=False).reshape(-1, 3)
            size = np.abs(change).max()
            if not np.isfinite(size) or size > 10.0:
                break
            x[free] += change * min(1.0, 0.1 / max(size, 1e-12))
            if size < tolerance_m:
                return x
        raise NotConverged(f"Newton's method left a change of {size:.1e} m after {trial + 1} iterations")

    def rest(
        self, material: Material, start: np.ndarray, gravity: np.ndarray, tolerance_m_s2: float = 1e-4
    ) -> np.ndarray:
        """Equilibrium (V, 3) near the shape `start`: nothing accelerates by more than the tolerance.

        Raises:
            NotConverged: not reached.
        """
        x, h = start.copy(), 0.01
        still = replace(material, c_normal=0.0, c_tangential=0.0)
        for _ in range(300):
            before = x.copy()  # dropping the velocity after every step takes the energy out
            try:
                x = self.solve_step(still, x, (-before / h, -before / h**2), gravity, 1 / h**2, 1 / h, 1e-8, most=20)
            except NotConverged:
                x, h = before, h / 4
                if h < 1e-4:
                    raise
                continue
            moved = np.abs(x - before).max()
            if moved < tolerance_m_s2 * h**2 and moved < 1e-5:
                return x
            h = min(h * 1.4, 1.0)
        raise NotConverged(f"no equilibrium: the sheet still moved by {moved:.1e} m in the last step of {h:.1e} s")

    def motion(
        self,
        material: Material,
        start: np.ndarray,
        held_path: np.ndarray,
        step_s: float,
        gravity: np.ndarray,
        start_velocity: np.ndarray | None = None,
        tolerance_m: float = 1e-5,  # of the last change; what is left after it is its square
    ) -> np.ndarray:
        """Shapes (T, V, 3) at 0, step_s, ... while the held vertices take the places `held_path` (T, held, 3).

        Raises:
            NotConverged: no next state was found.
        """
        h, count = step_s, len(held_path)
        out = np.empty((count, *start.shape))
        x0 = start.copy()
        x0[self.held] = held_path[0]
        v0 = np.zeros_like(x0) if start_velocity is None else start_velocity
        out[0] = x0
        for n in range(1, count):
            if n == 1:  # one step of the trapezoidal kind keeps second order from the start
                guess = x0 + h * v0
                history = (-x0 / h, -x0 / h**2 - v0 / h)
                rates = (1 / h**2, 1 / h)
                velocities = [v0]
            else:
                older = out[n - 2]
                guess = 2 * out[n - 1] - older
                if n > 2:
                    guess = 3 * out[n - 1] - 3 * older + out[n - 3]
                back = (-4 * out[n - 1] + older) / (2 * h)
                history = (back, 1.5 / h * back + (-4 * velocities[-1] + velocities[-2]) / (2 * h))
                rates = (2.25 / h**2, 1.5 / h)
            guess[self.held] = held_path[n]
            try:
                x = self.solve_step(material, guess, history, gravity, *rates, tolerance_m)
            except NotConverged:  # a buckle: from the last shape, and without the exact matrix
                guess = out[n - 1].copy()
                guess[self.held] = held_path[n]
                x = self.solve_step(material, guess, history, gravity, *rates, tolerance_m, most=200, exact=False)
            velocities = [velocities[-1], rates[1] * x + history[0]]
            out[n] = x
        return out


def _air(material: Material, F: np.ndarray, v: np.ndarray, area: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Drag (F, 3) of each face at its mean velocity, N, and its negative derivative over that velocity (F, 3, 3)."""
    fu, fv = F[..., 0], F[..., 1]
    normal = fu[:, [1, 2, 0]] * fv[:, [2, 0, 1]] - fu[:, [2, 0, 1]] * fv[:, [1, 2, 0]]
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    along = (v * normal).sum(-1, keepdims=True)
    across = v - along * normal
    speed = np.linalg.norm(across, axis=-1, keepdims=True)
    half = 0.5 * material.air_density_kg_m3 * area[:, None]
    pull = -half * (material.c_normal * np.abs(along) * along * normal + material.c_tangential * speed * across)
    outer = normal[:, :, None] * normal[:, None]
    slope = half[..., None] * (2 * material.c_normal * np.abs(along)[..., None] * outer)
    slope += half[..., None] * material.c_tangential * speed[..., None] * (np.eye(3) - outer)
    return pull, slope
