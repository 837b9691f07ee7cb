"""Contact with the table: inelastic and without penetration, friction by impulses with true sticking.

Moreau's time stepping, compiled in `benchmarks.concealed.inner`. The mass matrix is diagonal, so each vertex is solved exactly
and on its own: the normal impulse is what keeps the vertex from passing the table within the step, friction is what its law
allows for that impulse.
"""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Friction:
    """A dry friction law. The baseline is Coulomb's: equal in x and y, no more when sticking, at any speed."""

    mu_x: float
    mu_y: float
    static_ratio: float = 1.0
    """Largest sticking over sliding friction."""
    stribeck_speed_m_s: float = 0.005
    """Sliding friction falls from the sticking one over this speed. An elastic sheet comes off its table piece by piece: with
    a jump from sticking to sliding instead, the sheet as a whole would show nothing of the sticking friction."""
    fast_ratio: float = 1.0
    """Friction at high speed over friction at low speed."""
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
            speeds = (f.fading_speed_m_s, f.stribeck_speed_m_s)
            law = np.array([self.level_m, f.mu_x, f.mu_y, f.static_ratio, f.fast_ratio, *speeds, self.baseline_mu])
        self.arrays = (law, np.ones(self.count, dtype=np.bool_), np.zeros((2, self.count)), np.zeros(self.count))

    def take_impulses(self) -> tuple[np.ndarray, np.ndarray]:
        """Friction beyond the baseline's, (3, count) N s, and normal impulse, (count,) N s, since the last call."""
        missing = np.zeros((3, self.count))
        missing[:2] = self.arrays[2]
        normal = self.arrays[3].copy()
        self.arrays[2][:] = 0
        self.arrays[3][:] = 0
        return missing, normal
