"""Elastic properties that differ from an isotropic, uniform, linear sheet of the scanned size."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.sheet import Sheet


@dataclass
class AnisotropicStretch(Effect):
    """Orthotropic membrane whose shear modulus follows from its two stretch moduli, by Saint-Venant's rule.

    1/G = 1/E_u + 1/E_v + 2 nu_uv/E_u (Lekhnitskii, Theory of elasticity of an anisotropic body, 1963): the compliance in a direction at an angle t
    to the threads is then the plain mean cos(t)^2/E_u + sin(t)^2/E_v. Where both moduli are E it is the isotropic sheet's. `ratio_warp_weft` is
    E_u/E_v, exactly; shear alone, which no pull along a thread shows, is softer: by 7 % at a ratio of 2.5.
    """

    name: ClassVar[str] = "anisotropic_stretch"
    formula: ClassVar[str] = (
        "E_u = E sqrt(r), E_v = E / sqrt(r), nu_uv nu_vu = nu^2, 1/G = 1/E_u + 1/E_v + 2 nu/E (Saint-Venant)"
    )

    def sheet(self, sheet: Sheet) -> Sheet:
        """Stiffer along one thread, softer along the other."""
        root = np.sqrt(self.parameters["ratio_warp_weft"])
        stiffness = np.where(sheet.uu_j > 0, sheet.uu_j, 1.0)
        poisson = sheet.uv_j / stiffness
        softer = (1 + poisson) / ((root + 1 / root) / 2 + poisson)
        return replace(sheet, uu_j=sheet.uu_j * root, vv_j=sheet.vv_j / root, shear_j=sheet.shear_j * softer)


@dataclass
class AnisotropicBending(Effect):
    """Orthotropic plate whose torsion goes the way of the softer thread.

    B(t) = B_u cos(t)^4 + B_v sin(t)^4 + 2 T cos(t)^2 sin(t)^2 at an angle t to the threads, a woven fabric's (Cooper 1960, The stiffness of woven
    textiles, J. Text. Inst. 51). Cooper found T for each fabric; here both threads yield to a twist one after the other, like springs in a row: T is
    the harmonic mean of B_u and B_v, where Huber's rule for plates takes their geometric mean. `ratio_warp_weft` is B_u/B_v, exactly; torsion
    falls from B by 11 % at a ratio of 2.7.
    """

    name: ClassVar[str] = "anisotropic_bending"
    formula: ClassVar[str] = (
        "B_u = B sqrt(r) against curvature along u, B_v = B / sqrt(r), torsion 2 / (1/B_u + 1/B_v): "
        "B(t) = B_u cos(t)^4 + B_v sin(t)^4 + 2 T cos(t)^2 sin(t)^2"
    )

    def sheet(self, sheet: Sheet) -> Sheet:
        """Stiffer along one thread, softer along the other, and softer against torsion."""
        root = np.sqrt(self.parameters["ratio_warp_weft"])
        return replace(
            sheet,
            bend_u_n_m3=sheet.bend_u_n_m3 * root,
            bend_v_n_m3=sheet.bend_v_n_m3 / root,
            twist_n_m3=sheet.twist_n_m3 * (2 / (root + 1 / root)),
        )


@dataclass
class StrainStiffening(Effect):
    """Threads get stiffer while their crimp is drawn out, and no more once they are straight.

    The load of a woven strip rises ever more steeply at first and in a straight line after (Hearle, Grosberg and Backer 1969, Structural mechanics of
    fibers, yarns and fabrics). The secant modulus here goes to that of straight threads exponentially. `growth` is its relative growth per
    strain where the growth begins, at no strain: a straight line fitted to strains of 1/growth has 10 % less of it.
    """

    name: ClassVar[str] = "strain_stiffening"
    formula: ClassVar[str] = (
        "stress of each thread E e (1 + straight (1 - exp(-growth e / straight))) where e, Green's strain along it, is above 0: a secant modulus"
    )

    def sheet(self, sheet: Sheet) -> Sheet:
        """The membrane has the law built in."""
        return replace(sheet, growth=self.parameters["growth"], straight=self.extras["straight"])


@dataclass
class Shrinkage(Effect):
    """The cloth is smaller (or larger) than its scan, at one end more than at the other; grips hold the vertices where the scan has them.

    As cloth that was tighter, or dried sooner, at one end. The share by which a place has shrunk varies linearly over the sheet: the one way of
    varying that leaves a flat sheet flat and free of stress, to first order (Saint-Venant's compatibility: a linear strain is that of a displacement).
    Its strain is taken from Green's, as where the rest metric grows (Efrati, Sharon and Kupferman 2009). `scale_u` and `scale_v` are the
    mean over the sheet; the corner that shrank most is off by `uneven` of that, 15 to 30 %.
    """

    name: ClassVar[str] = "shrinkage"
    formula: ClassVar[str] = (
        "rest spacing 1 + (scale - 1) (1 + uneven s), scale_u along u and scale_v along v, s from -1 to 1 over the sheet along `way`; "
        "mass unchanged; held vertices at the places of the scan"
    )

    def sheet(self, sheet: Sheet) -> Sheet:
        """Other rest lengths; moduli times area follow the area."""
        scale_u, scale_v = self.parameters["scale_u"], self.parameters["scale_v"]
        area = scale_u * scale_v
        grid = sheet.grid
        half = np.array([(grid.columns - 1) * grid.du_m, (grid.rows - 1) * grid.dv_m]) / 2
        way = np.array([np.cos(self.extras["way"]), np.sin(self.extras["way"])])
        uneven = []
        for scale, middle in ((scale_u, [grid.du_m / 2, 0]), (scale_v, [0, grid.dv_m / 2])):
            share = self.extras["uneven"] * ((grid.flat_uv_m + middle - half) / half) @ way / np.abs(way).sum()
            uneven.append((((1 + (scale - 1) * (1 + share)) / scale) ** 2 - 1) / 2)
        return replace(
            sheet,
            uneven_u=uneven[0],
            uneven_v=uneven[1],
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
