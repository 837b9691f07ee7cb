"""The sheet simulator against theory."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sim1.mismatch.dynamics import HeldSheet
from sim1.mismatch.sheet import Material, Sheet, Swatch, elastic_energy, place_on, refined
from sim1.stage import BadInput

GRAVITY = np.array([0.0, 0.0, -9.81])
CLOTH = Material(area_density_kg_m2=0.2, stretch_n_m=400.0, poisson=0.3, bending_n_m=2e-5, damping_s=1e-3)
NOTHING = np.array([], dtype=int)


def flat(sheet: Sheet, kind: str) -> np.ndarray:
    u, v = sheet.material_m.T
    return np.stack([u, 0 * u, -v] if kind == "hanging" else [u, v, 0 * u], axis=1)


def free(steps: int) -> np.ndarray:
    return np.zeros((steps, 0, 3))


def swatch(n: int, side: float = 0.3) -> Sheet:
    return Swatch(side_m=side, vertices_per_side=n).sheet()


def bent(sheet: Sheet, radius: float, angle: float) -> np.ndarray:
    across = np.array([np.cos(angle), np.sin(angle)])
    a, b = sheet.material_m @ across, sheet.material_m @ np.array([-across[1], across[0]])
    return np.stack([radius * np.sin(a / radius), b, radius * np.cos(a / radius)], axis=1)


def test_forces_are_the_slope_of_the_energy():
    sheet, stream = swatch(5), np.random.default_rng(0)
    stiff = Material(**{**CLOTH.__dict__, "bending_n_m": 1e-2})
    x = bent(sheet, 0.1, 0.4) + 0.003 * stream.standard_normal((25, 3))
    force = HeldSheet(sheet, NOTHING).forces(stiff, x, 0 * x)
    for vertex, axis in ((0, 0), (6, 2), (12, 1), (24, 2)):
        shift = np.zeros_like(x)
        shift[vertex, axis] = 1e-6
        slope = (elastic_energy(sheet, stiff, x + shift) - elastic_energy(sheet, stiff, x - shift)) / 2e-6
        assert force[vertex, axis] == pytest.approx(-slope, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("angle", [0.0, 0.4, np.pi / 4])
def test_a_cylinder_costs_half_the_rigidity_times_the_squared_curvature(angle):
    radius, errors = 0.1, []
    for n in (9, 17):
        sheet = swatch(n)
        x = bent(sheet, radius, angle)
        errors.append(0.5 * (x * (sheet.bending_matrix @ x)).sum() / (0.5 / radius**2 * 0.3**2) - 1)
    assert abs(errors[0]) < 0.06
    assert abs(errors[1]) < abs(errors[0]) / 3


def test_turning_or_moving_a_sheet_costs_nothing_and_anything_else_does():
    for sheet in (swatch(6), refined(swatch(6))[0]):
        x = flat(sheet, "hanging") @ Rotation.from_euler("xyz", [0.3, 1.1, -0.7]).as_matrix().T + 3.0
        assert elastic_energy(sheet, CLOTH, x) == pytest.approx(0, abs=1e-12)
        values = np.linalg.eigvalsh(sheet.bending_matrix.toarray())
        assert (values < 1e-6 * values[-1]).sum() == 3  # constant, u and v: no shape bends for free


def test_free_fall_is_exact():
    sheet, h = swatch(4), 0.01
    x = flat(sheet, "lying")
    path = HeldSheet(sheet, NOTHING).motion(CLOTH, x, free(31), h, GRAVITY)
    drop = (path[-1] - x)[:, 2]
    assert np.ptp(drop) < 1e-9
    assert drop.mean() == pytest.approx(
        -0.5 * 9.81 * 0.3**2, rel=0.02
    )  # an implicit first step costs h of a 0.3 s fall
    speed = (1.5 * path[-1] - 2 * path[-2] + 0.5 * path[-3])[:, 2].mean() / h
    assert speed == pytest.approx(-9.81 * 0.3, rel=1e-6)


def test_a_flat_sheet_falls_through_air_at_its_terminal_velocity():
    sheet = swatch(4)
    airy = Material(**{**CLOTH.__dict__, "c_normal": 1.3})
    path = HeldSheet(sheet, NOTHING).motion(airy, flat(sheet, "lying"), free(301), 0.01, GRAVITY)
    speed = -(path[-1] - path[-2])[:, 2].mean() / 0.01
    assert speed == pytest.approx(np.sqrt(2 * 0.2 * 9.81 / (1.2 * 1.3)), rel=1e-3)


def test_a_hanging_sheet_stretches_by_its_own_weight():
    soft = Material(**{**CLOTH.__dict__, "stretch_n_m": 100.0, "poisson": 0.0})
    for n in (5, 9):
        sheet = swatch(n)
        body = HeldSheet(sheet, np.arange(n))
        rest = body.rest(soft, flat(sheet, "hanging"), GRAVITY)
        longer = -rest[-1, 2] - 0.3
        assert longer == pytest.approx(0.2 * 9.81 * 0.3**2 / (2 * 100.0), rel=0.02)


def test_a_stiff_sheet_swings_with_the_period_of_a_compound_pendulum():
    n, side = 9, 0.3
    sheet = swatch(n, side)
    stiff = Material(area_density_kg_m2=0.2, stretch_n_m=5e4, poisson=0.3, bending_n_m=50.0, damping_s=0.0)
    pivot, angle = n // 2, 0.05
    turn = np.array([[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0], [np.sin(angle), 0, np.cos(angle)]])
    x = flat(sheet, "hanging")
    x = (x - x[pivot]) @ turn.T
    inertia, arm = side**2 / 6 + side**2 / 4, side / 2  # per mass, about the middle of the upper edge
    period = 2 * np.pi * np.sqrt(inertia / (9.81 * arm))
    h = period / 160
    path = HeldSheet(sheet, np.array([pivot])).motion(stiff, x, np.zeros((330, 1, 3)), h, GRAVITY)
    swing = path[:, -1 - n // 2, 0]
    turns = np.flatnonzero(np.diff(np.sign(swing))) + 1
    crossing = [k - swing[k] / (swing[k] - swing[k - 1]) for k in turns]
    assert 2 * (crossing[2] - crossing[0]) / 2 * h == pytest.approx(period, rel=0.01)
    assert np.abs(swing[300:]).max() > 0.97 * abs(swing[0])  # almost nothing is lost in two periods


def test_halving_the_step_quarters_the_error():
    sheet = swatch(4)
    body = HeldSheet(sheet, np.arange(4))
    rest = body.rest(CLOTH, flat(sheet, "hanging"), GRAVITY)
    ends = []
    for h in (1 / 100, 1 / 200, 1 / 400, 1 / 800):
        time = h * np.arange(round(0.5 / h) + 1)
        held = np.repeat(rest[None, :4], len(time), axis=0)
        held[:, :, 1] += 0.002 * np.sin(2 * np.pi * time)[:, None] ** 3
        ends.append(body.motion(CLOTH, rest, held, h, GRAVITY, tolerance_m=1e-10)[-1])
    error = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    assert error[1] < error[0] / 3
    assert error[2] < error[1] / 3


def test_damping_takes_energy_and_never_gives_it():
    sheet = swatch(4)
    body = HeldSheet(sheet, np.arange(4))
    x = flat(sheet, "hanging")
    x[:, 2] *= 1.02
    heights = {}
    for tau in (0.0, 5e-3):
        material = Material(**{**CLOTH.__dict__, "damping_s": tau})
        path = body.motion(material, x, np.repeat(x[None, :4], 61, axis=0), 5e-4, 0 * GRAVITY)
        heights[tau] = np.ptp(path[40:, -1, 2])
    assert heights[5e-3] < 0.7 * heights[0.0]


def test_points_are_found_on_the_sheet_and_refused_beside_it():
    sheet = swatch(5)
    points = np.random.default_rng(1).uniform(0, 0.3, (50, 2))
    face, weight = place_on(sheet, points)
    np.testing.assert_allclose((sheet.material_m[sheet.faces[face]] * weight[..., None]).sum(1), points, atol=1e-12)
    with pytest.raises(BadInput, match="off the sheet"):
        place_on(sheet, np.array([[0.31, 0.1]]))


def test_a_mesh_that_cannot_bend_is_refused():
    with pytest.raises(BadInput, match="4 x 4"):
        _ = swatch(2).bending_matrix
