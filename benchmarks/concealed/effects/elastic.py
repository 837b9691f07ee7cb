"""Elastic properties that differ from an isotropic, uniform, linear sheet of the scanned size."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.sheet import Sheet


@dataclass
class AnisotropicStretch(Effect):
    """Orthotropic membrane; the coupling and the shear modulus stay those of the isotropic sheet."""

    name: ClassVar[str] = "anisotropic_stretch"
    formula: ClassVar[str] = "E_u = E sqrt(r), E_v = E / sqrt(r), nu_uv nu_vu = nu^2, G = E / (2 (1 + nu))"

    def sheet(self, sheet: Sheet) -> Sheet:
        """Stiffer along one thread, softer along the other."""
        root = np.sqrt(self.parameters["ratio_warp_weft"])
        return replace(sheet, uu_j=sheet.uu_j * root, vv_j=sheet.vv_j / root)


@dataclass
class AnisotropicBending(Effect):
    """Orthotropic plate; torsion stays as it was."""

    name: ClassVar[str] = "anisotropic_bending"
    formula: ClassVar[str] = "B_u = B sqrt(r) against curvature along u, B_v = B / sqrt(r), torsion B"

    def sheet(self, sheet: Sheet) -> Sheet:
        """Stiffer along one thread, softer along the other."""
        root = np.sqrt(self.parameters["ratio_warp_weft"])
        return replace(sheet, bend_u_n_m3=sheet.bend_u_n_m3 * root, bend_v_n_m3=sheet.bend_v_n_m3 / root)


@dataclass
class StrainStiffening(Effect):
    """Threads get stiffer as they are drawn straight."""

    name: ClassVar[str] = "strain_stiffening"
    formula: ClassVar[str] = (
        "stress of each thread E (1 + growth max(e, 0)) e, e Green's strain along it: a secant modulus"
    )

    def sheet(self, sheet: Sheet) -> Sheet:
        """The membrane has the law built in."""
        return replace(sheet, growth=self.parameters["growth"])


@dataclass
class Shrinkage(Effect):
    """The cloth is smaller (or larger) than its scan; grips hold the vertices where the scan has them."""

    name: ClassVar[str] = "shrinkage"
    formula: ClassVar[str] = (
        "rest spacing times scale_u, scale_v; mass unchanged; held vertices at the places of the scan"
    )

    def sheet(self, sheet: Sheet) -> Sheet:
        """Other rest lengths; moduli times area follow the area."""
        scale_u, scale_v = self.parameters["scale_u"], self.parameters["scale_v"]
        area = scale_u * scale_v
        return replace(
            sheet,
            scale_u=scale_u,
            scale_v=scale_v,
            uu_j=sheet.uu_j * area,
            vv_j=sheet.vv_j * area,
            uv_j=sheet.uv_j * area,
            shear_j=sheet.shear_j * area,
            bend_u_n_m3=sheet.bend_u_n_m3 * area,
            bend_v_n_m3=sheet.bend_v_n_m3 * area,
            twist_n_m3=sheet.twist_n_m3 * area,
        )
