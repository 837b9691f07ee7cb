"""Contact with the table: inelastic and without penetration, friction by impulses with true sticking.

Moreau's time stepping. The mass matrix is diagonal, so each vertex is solved exactly and on its own: the normal impulse
is what keeps the vertex from passing the table within the step, friction is what its law allows for that impulse.
"""

from dataclasses import dataclass, field

import numpy as np
from numba import njit


@dataclass(frozen=True)
class Friction:
    """A dry friction law. The baseline is Coulomb's: equal in x and y, no more when sticking, at any speed."""

    mu_x: float
    mu_y: float
    static_ratio: float = 1.0
    """Largest sticking over sliding friction."""
    fast_ratio: float = 1.0
    """Friction at high speed over friction at creep."""
    fading_speed_m_s: float = 0.1


@dataclass
class Contact:
    """The table under one sheet. `level_m` is the height at which the sheet's middle surface rests; None: no table."""

    count: int
    level_m: float | None
    friction: Friction
    baseline_mu: float
    arrays: tuple = field(init=False, repr=False)
    """(law, sticking, missing impulse (2, count), normal impulse (count)) for the compiled step; empty law: no table."""

    def __post_init__(self) -> None:
        """Lay out what the compiled step reads and writes."""
        law = np.zeros(0)
        if self.level_m is not None:
            f = self.friction
            law = np.array(
                [self.level_m, f.mu_x, f.mu_y, f.static_ratio, f.fast_ratio, f.fading_speed_m_s, self.baseline_mu]
            )
        self.arrays = (law, np.ones(self.count, dtype=np.bool_), np.zeros((2, self.count)), np.zeros(self.count))

    def take_impulses(self) -> tuple[np.ndarray, np.ndarray]:
        """Friction beyond the baseline's, (3, count) N s, and normal impulse, (count,) N s, since the last call."""
        missing = np.zeros((3, self.count))
        missing[:2] = self.arrays[2]
        normal = self.arrays[3].copy()
        self.arrays[2][:] = 0
        self.arrays[3][:] = 0
        return missing, normal


@njit(fastmath=True, nogil=True, cache=True, error_model="numpy")
def touch(x, v, inverse_mass, dt, contact):
    """Change the velocities (3, count) so that no vertex passes the table; see `Contact.arrays`.

    Friction in two directions follows maximum dissipation over an ellipse: the force is normal to the ellipse of the forces
    allowed, not opposite to the velocity. Sticking is a state (Karnopp): a vertex that stuck in the last step holds up to
    `static_ratio` times the sliding friction.
    """
    law, sticking, missing, pressed = contact
    level, mu_x, mu_y, static_ratio, fast_ratio, fading, mu = law[0], law[1], law[2], law[3], law[4], law[5], law[6]
    for k in range(x.shape[1]):
        if inverse_mass[k] == 0.0:
            continue
        lowest = (level - x[2, k]) / dt
        if v[2, k] >= lowest:
            sticking[k] = False
            continue
        mass = 1 / inverse_mass[k]
        normal = mass * (lowest - v[2, k])
        v[2, k] = lowest
        pressed[k] += normal
        wx, wy = v[0, k], v[1, k]
        speed = np.sqrt(wx * wx + wy * wy)
        if speed == 0.0:
            sticking[k] = True
            continue
        share = fast_ratio + (1 - fast_ratio) * np.exp(-speed / fading)
        limit_x, limit_y = mu_x * normal * share + 1e-300, mu_y * normal * share + 1e-300
        needed = mass * np.sqrt((wx / limit_x) ** 2 + (wy / limit_y) ** 2)
        allowed = static_ratio if sticking[k] else 1.0
        if needed <= allowed:
            v[0, k], v[1, k] = 0.0, 0.0
            sticking[k] = True
        else:
            length = np.sqrt((limit_x * wx) ** 2 + (limit_y * wy) ** 2)
            v[0, k] -= inverse_mass[k] * limit_x * limit_x * wx / length
            v[1, k] -= inverse_mass[k] * limit_y * limit_y * wy / length
            sticking[k] = False
        baseline = min(mu * normal * inverse_mass[k] / speed, 1.0)
        missing[0, k] += mass * (v[0, k] - wx * (1 - baseline))
        missing[1, k] += mass * (v[1, k] - wy * (1 - baseline))
