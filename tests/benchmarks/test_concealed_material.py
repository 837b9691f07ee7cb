"""What makes a concealed cloth another material does what its formula says, and is the simpler law's in its limit."""

import itertools

import numpy as np
import pytest
from concealed_world import flat, force, rolled, world_of

from benchmarks.concealed.bending import Plate
from benchmarks.concealed.effects.curl import RestCurvature
from benchmarks.concealed.effects.elastic import AnisotropicBending, AnisotropicStretch, Shrinkage, StrainStiffening
from benchmarks.concealed.membrane import Membrane
from benchmarks.concealed.simulate import Gap


def test_anisotropy_keeps_the_geometric_mean():
    base = world_of().sheet
    stretch = AnisotropicStretch({"ratio_warp_weft": 4.0}).sheet(base)
    bending = AnisotropicBending({"ratio_warp_weft": 4.0}).sheet(base)
    cell, vertex = base.grid.at(3, 3), base.grid.at(5, 5)
    assert stretch.uu_j[cell] / stretch.vv_j[cell] == pytest.approx(4)
    assert stretch.uu_j[cell] * stretch.vv_j[cell] == pytest.approx(base.uu_j[cell] ** 2)
    assert bending.bend_u_n_m3[vertex] / bending.bend_v_n_m3[vertex] == pytest.approx(4)


def test_orthotropic_cloth_is_isotropic_at_a_ratio_of_one():
    base = world_of().sheet
    for effect in (AnisotropicStretch({"ratio_warp_weft": 1.0}), AnisotropicBending({"ratio_warp_weft": 1.0})):
        for name in ("uu_j", "vv_j", "uv_j", "shear_j", "bend_u_n_m3", "bend_v_n_m3", "twist_n_m3"):
            assert getattr(effect.sheet(base), name) == pytest.approx(getattr(base, name), rel=1e-12)


def test_compliance_in_any_direction_is_the_mean_of_those_along_the_threads():
    """Saint-Venant's shear modulus: 1/E(t) = cos^2/E_u + sin^2/E_v."""
    sheet = AnisotropicStretch({"ratio_warp_weft": 2.5}).sheet(world_of().sheet)
    cell = sheet.grid.at(3, 3)
    uu, vv, uv, shear = (array[cell] for array in (sheet.uu_j, sheet.vv_j, sheet.uv_j, sheet.shear_j))
    soft = np.linalg.inv([[uu, uv, 0], [uv, vv, 0], [0, 0, shear]])
    for t in np.linspace(0, np.pi, 7):
        c, s = np.cos(t) ** 2, np.sin(t) ** 2
        stress = np.array([c, s, np.cos(t) * np.sin(t)])
        assert stress @ soft @ stress == pytest.approx(c * soft[0, 0] + s * soft[1, 1])


def test_bending_falls_from_thread_to_thread_as_coopers_curve_with_torsion_between():
    base = world_of().sheet
    sheet = AnisotropicBending({"ratio_warp_weft": 2.7}).sheet(base)
    vertex = cell = base.grid.at(5, 5)
    along, across, torsion = (
        getattr(sheet, name)[vertex] / getattr(base, name)[cell]
        for name in ("bend_u_n_m3", "bend_v_n_m3", "twist_n_m3")
    )
    assert along / across == pytest.approx(2.7)
    assert torsion == pytest.approx(2 / (1 / along + 1 / across))
    assert 0.85 < torsion / np.sqrt(along * across) < 0.95, "Huber's is the geometric mean"
    assert across < (along + across) / 4 + torsion / 2 < along


def test_stiffening_raises_the_stress_of_a_stretched_sheet_only():
    base = world_of().sheet
    none = np.zeros(0, dtype=int)
    sheets = [
        Membrane(sheet, none) for sheet in (base, StrainStiffening({"growth": 20.0}, {"straight": 4.0}).sheet(base))
    ]
    for stretch, factor in ((1.02, 1 + 4 * (1 - np.exp(-20 * 0.0202 / 4))), (0.99, 1.0)):
        state = flat(world_of())
        state.x[0] *= stretch
        edge = base.grid.at(5, 0)
        soft, stiff = (membrane.forces(state.x, state.v)[0, edge] for membrane in sheets)
        assert stiff / soft == pytest.approx(factor, rel=1e-6)


def test_stiffening_grows_at_its_rate_at_small_strain_and_ends_with_straight_threads():
    base = world_of().sheet
    sheet = StrainStiffening({"growth": 20.0}, {"straight": 4.0}).sheet(base)
    soft, stiff = (Membrane(one, np.zeros(0, dtype=int)) for one in (base, sheet))
    edge = base.grid.at(5, 0)

    def more(strain):
        state = flat(world_of())
        state.x[0] *= np.sqrt(1 + 2 * strain)
        pulls = [membrane.forces(state.x, state.v)[0, edge] for membrane in (stiff, soft)]
        return pulls[0] / pulls[1] - 1

    assert more(1e-4) / 1e-4 == pytest.approx(20.0, rel=1e-3)
    assert 0.85 < more(1 / 20) / 1.0 < 0.95, "moderately less than a straight line"
    assert more(2.0) == pytest.approx(4.0, rel=1e-3)


def test_a_stiffening_sheet_gives_back_what_it_took_whatever_the_way():
    """Stretched along warp, then along weft, then let go in the same order."""
    base = world_of().sheet
    sheet = StrainStiffening({"growth": 40.0}, {"straight": 4.5}).sheet(base)
    membrane, rest = Membrane(sheet, np.zeros(0, dtype=int)), flat(world_of())
    corners = np.array([[0.0, 0.0], [0.03, 0.0], [0.03, 0.02], [0.0, 0.02], [0.0, 0.0]])
    work = []
    for before, after in itertools.pairwise(corners):
        shares = np.linspace(0.0, 1.0, 201)[:, None]
        shapes = [
            rest.x * np.array([*np.sqrt(1 + 2 * strain), 1.0])[:, None] for strain in before + shares * (after - before)
        ]
        middles = [(a + b) / 2 for a, b in itertools.pairwise(shapes)]
        forces = [membrane.forces(x, rest.v).copy() for x in middles]
        work.append(sum(float((f * (b - a)).sum()) for f, a, b in zip(forces, shapes[:-1], shapes[1:], strict=True)))
    assert abs(sum(work)) < 1e-4 * abs(np.array(work)).max()


def test_a_shrunken_sheet_is_at_rest_at_its_new_size_with_the_old_mass():
    base = world_of().sheet
    sheet = Shrinkage({"scale_u": 0.98, "scale_v": 0.97}, {"uneven": 0.0, "way": 1.0}).sheet(base)
    state = flat(world_of())
    state.x[0] *= 0.98
    state.x[1] *= 0.97
    assert np.abs(Membrane(sheet, np.zeros(0, dtype=int)).forces(state.x, state.v)).max() < 1e-10
    assert sheet.mass_kg.sum() == base.mass_kg.sum()


def test_uneven_shrinkage_has_its_mean_and_leaves_the_flat_sheet_without_stress():
    """A strain that is linear over the sheet is that of a displacement: (a (p u^2/2 + q u v) - b p v^2/2, b (p u v + q v^2/2) - a q u^2/2)."""
    world = world_of()
    base, cloth, grid = world.sheet, world.cloth, world.sheet.grid
    way = 0.7
    effect = Shrinkage({"scale_u": 0.985, "scale_v": 0.99}, {"uneven": 0.3, "way": way})
    sheet = effect.sheet(base)
    rest_u = 0.985 * np.sqrt(1 + 2 * sheet.uneven_u[grid.inside].reshape(grid.rows, grid.columns)[:, :-1])
    assert rest_u.mean() == pytest.approx(0.985, abs=1e-7)
    farthest = np.abs(rest_u - 0.985).max() / 0.015
    assert 0.28 < farthest < 0.3
    u, v = grid.flat_uv_m.T - np.array([[cloth.size_u_m], [cloth.size_v_m]]) / 2
    slope = 0.3 / (np.cos(way) + np.sin(way))
    p, q = slope * np.cos(way) / (cloth.size_u_m / 2), slope * np.sin(way) / (cloth.size_v_m / 2)
    a, b = 0.985 - 1, 0.99 - 1
    even, uneven = flat(world), flat(world)
    even.x[0], even.x[1] = 0.985 * u, 0.99 * v
    uneven.x[0] = 0.985 * u + a * (p * u**2 / 2 + q * u * v) - b * p * v**2 / 2
    uneven.x[1] = 0.99 * v + b * (p * u * v + q * v**2 / 2) - a * q * u**2 / 2
    membrane = Membrane(sheet, np.zeros(0, dtype=int))
    forces = [np.abs(membrane.forces(state.x, state.v)).max() for state in (uneven, even)]
    assert forces[0] < 0.05 * forces[1]


@pytest.mark.parametrize("axis", [0, 1])
def test_a_curled_sheet_is_at_rest_at_its_curvature(axis):
    effect = RestCurvature({"kappa_u": 5.0 * (axis == 0), "kappa_v": 5.0 * (axis == 1)}, {"fade": 0.0})
    world = world_of(effect)
    effect.begin(world)
    grid = world.sheet.grid
    net = grid.inside.reshape(grid.rows, grid.columns)[3:-3, 3:-3]
    gap = Gap(world, [effect])
    start = force(effect, world, flat(world))
    assert np.abs(start[2]).max() > 1e-5
    pulls = {}
    for kappa in (5.0, -5.0):
        state = rolled(world, kappa, axis)
        bent = np.zeros_like(state.x)
        Plate(world.sheet).add(state.x, state.v, bent)
        rim = grid.at(0, 5) if axis == 1 else grid.at(5, 0)
        pulls[kappa] = np.linalg.norm((bent + gap.force(state, state.v))[:, rim])
        assert np.abs(bent[:, net]).max() < 0.02 * pulls[kappa] or kappa > 0
    assert pulls[5.0] < 0.02 * pulls[-5.0]


def test_a_curl_that_fades_towards_the_edges_has_its_mean_over_the_sheet():
    effect = RestCurvature({"kappa_u": 4.0, "kappa_v": -2.0}, {"fade": 0.25})
    world = world_of(effect)
    effect.begin(world)
    grid = world.sheet.grid
    for axis, (mean, stiffness) in enumerate(
        ((4.0, world.sheet.bend_u_n_m3), (-2.0, world.sheet.bend_v_n_m3)),
    ):
        share = -effect._moment[axis, grid.inside] / np.where(stiffness > 0, stiffness, 1.0)[grid.inside] / mean
        inner = stiffness[grid.inside] > 0
        area = grid.area_m2[grid.inside]
        assert share[inner] @ area[inner] / area[inner].sum() == pytest.approx(1.0, abs=0.02)
        assert share.max() == pytest.approx(1 + 0.25 * 2 / 3, abs=0.005)
