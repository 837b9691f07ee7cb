"""Small vibrations of a sheet against beam theory: a free plate without coupling of its curvatures bends along one side as a beam."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh
from small_bundle import SIDE_M, empty_bundle, plain_world

from sim1.cloth.precise.newton import net_width
from sim1.cloth.precise.scene import prepare
from sim1.cloth.precise.stiffness import derivative
from sim1.cloth.precise.world import pack

ROOTS = np.array([4.730041, 7.853205])  # of cos x cosh x = 1: free at both ends


@pytest.fixture(scope="module")
def flat():
    bundle = empty_bundle(duration_s=0.2)
    return bundle, replace(plain_world(bundle), gravity_m_s2=(0.0, 0.0, 0.0), bending_ratio=1.7)


def whole(band: np.ndarray) -> np.ndarray:
    """The symmetric matrix whose lower diagonals are the columns of `band`."""
    size = len(band)
    lower = sum(np.diag(band[: size - k, k], -k) for k in range(min(band.shape[1], size)))
    return lower + np.tril(lower, -1).T


def vibrations(scene, world) -> tuple[np.ndarray, np.ndarray]:
    """Angular frequencies [rad/s] and shapes (V, modes) across a flat sheet that nothing holds."""
    points = scene.sheet.material_m
    x = np.column_stack([points[:, 0], 0.0 * points[:, 0], -points[:, 1]])
    cloth = pack(scene.sheet, [world])
    nothing, free = np.zeros((len(scene.net.first) - 1, 3)), np.zeros(len(scene.net.held), bool)
    matrices = []
    for mass_rate in (0.0, 1.0):
        band = np.zeros((x.size, 3 * net_width(scene.net) + 3))
        derivative(
            x, np.zeros_like(x), mass_rate, 0.0, 1e-3, scene.net, cloth, nothing, nothing, free, False, band
        )  # fmt: skip
        matrices.append(whole(band)[1::3, 1::3])
    stiff, mass = matrices[0], matrices[1] - matrices[0]
    squares, shapes = eigh(stiff, mass)
    return np.sqrt(np.maximum(squares, 0.0)), shapes


def beam_errors(bundle, world, finer: int) -> np.ndarray:
    """Relative errors of the two lowest beam modes along u."""
    scene = prepare(bundle, bundle.recordings[0], 1 / 60, finer=finer)
    frequency, shapes = vibrations(scene, world)
    u = scene.sheet.material_m[:, 0] / SIDE_M
    errors = []
    for root in ROOTS:
        ratio = (np.cosh(root) - np.cos(root)) / (np.sinh(root) - np.sin(root))
        beam = np.cosh(root * u) + np.cos(root * u) - ratio * (np.sinh(root * u) + np.sin(root * u))
        alike = np.abs(shapes.T @ beam) / np.linalg.norm(shapes, axis=0) / np.linalg.norm(beam)
        theory = (
            root**2 / SIDE_M**2 * np.sqrt(np.sqrt(world.bending_ratio) * world.bending_n_m / world.area_density_kg_m2)
        )
        errors.append(frequency[np.argmax(alike)] / theory - 1.0)
    return np.array(errors)


def test_a_coarse_sheet_vibrates_as_a_beam(flat):
    assert np.abs(beam_errors(*flat, finer=0)).max() < 0.08
    assert np.abs(beam_errors(*flat, finer=1)).max() < 0.05
    assert np.abs(beam_errors(*flat, finer=2)).max() < 0.02


def test_refinement_takes_more_than_half_of_the_error(flat):
    coarse, fine = beam_errors(*flat, finer=1), beam_errors(*flat, finer=2)
    assert (np.abs(fine) < 0.5 * np.abs(coarse)).all()


def test_the_mass_of_the_sheet_is_its_area_times_its_density(flat):
    bundle, world = flat
    scene = prepare(bundle, bundle.recordings[0], 1 / 60)
    cloth = pack(scene.sheet, [world])
    nothing, free = np.zeros((len(scene.net.first) - 1, 3)), np.zeros(len(scene.net.held), bool)
    x = np.zeros((len(scene.sheet.material_m), 3))
    x[:, [0, 2]] = scene.sheet.material_m
    bands = []
    for mass_rate in (0.0, 1.0):
        bands.append(np.zeros((x.size, 3 * net_width(scene.net) + 3)))
        derivative(
            x, np.zeros_like(x), mass_rate, 0.0, 1e-3, scene.net, cloth, nothing, nothing, free, False, bands[-1]
        )  # fmt: skip
    assert whole(bands[1] - bands[0]).sum() == pytest.approx(3 * world.area_density_kg_m2 * SIDE_M**2)
