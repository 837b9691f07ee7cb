"""Warp and weft differ in stretch."""

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from sim1.cloth.avbd.threads import WARP, align
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class AnisotropicStretch(Effect):
    """Orthotropic plane stress: E_warp = E sqrt(r), E_weft = E / sqrt(r), nu_12 nu_21 = nu^2, shear modulus unchanged."""

    name: ClassVar[str] = "anisotropic_stretch"
    signature: ClassVar[str] = "a pull along the threads stretches the sheet by another amount than one across them"
    source: ClassVar[str] = "orthotropic lamina in plane stress (Jones 1999, section 2.5)"

    typical: ClassVar[str] = "0.3 to 3"
    varied: ClassVar[str] = "pulled taut, held by the neighbouring edge (the pull then runs along the other threads)"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="ratio_warp_weft", unit="1", scale=0.7, kind="log", centre=1.0, low=0.02, high=50.0),
    )

    ratio_warp_weft: float  # 1
    warp: tuple[float, float, float] = WARP  # direction of the warp threads at rest, for all effects

    fixed: ClassVar[dict[str, str]] = {"warp": "1"}

    def __post_init__(self) -> None:
        """Refuse what cannot be meant.

        Raises:
            ValueError: as every effect, or a warp direction without a length.
        """
        super().__post_init__()
        if len(self.warp) != 3 or not np.linalg.norm(self.warp) > 0.0:
            raise ValueError(f"{self.name}: warp is {self.warp!r}, must be a direction in space")

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, stretch_ratio=values["ratio_warp_weft"])

    def shape(self, solver: Any) -> None:
        """Replace the isotropic law of every triangle."""
        sheet = solver.sheet
        align(sheet, solver.model.particle_q.numpy(), solver.warp)
        law = np.stack([orthotropic(c, self.ratio_warp_weft) for c in sheet.triangle_law.numpy().astype(float)])
        sheet.triangle_law.assign(law.astype(np.float32))


def orthotropic(isotropic: np.ndarray, ratio: float) -> np.ndarray:
    """Law (3, 3) along warp and weft from an isotropic one; the geometric mean of the two stiffnesses stays."""
    root = math.sqrt(ratio)
    law = isotropic.copy()
    law[0, 0] *= root
    law[1, 1] /= root
    return law
