"""What the cell's solver makes of effects that act through the air and in the plane of the cloth, against theory."""

import numpy as np
import pytest
from avbd_sheets import G, Run, cloth, hold, square_grid

from sim1.cloth.effects.added_mass import AddedMass
from sim1.cloth.effects.anisotropic_stretch import AnisotropicStretch
from sim1.cloth.effects.shrinkage import Shrinkage
from sim1.cloth.effects.strain_stiffening import StrainStiffening
from sim1.cloth.effects.wind import Wind

DENSITY = 0.2
POINTS, FACES = square_grid(6, 6, 0.02)
UPRIGHT = POINTS @ np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
FREE = (0.0, 0.0, 0.0)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_air_that_is_carried_along_slows_a_falling_plate_and_not_one_that_falls_along_itself(integrator):
    added = AddedMass(mass=0.3)
    lying = Run(cloth(POINTS, FACES, density=DENSITY), 1 / 500, effects=(added,), integrator=integrator)
    upright = Run(cloth(UPRIGHT, FACES, density=DENSITY), 1 / 500, effects=(added,), integrator=integrator)
    slowed = G * DENSITY / (DENSITY + added.mass)
    assert lying.trace(50, lambda now: now.v[:, 2].mean())[-1] == pytest.approx(-slowed * 0.1, rel=0.01)
    assert upright.trace(50, lambda now: now.v[:, 2].mean())[-1] == pytest.approx(-G * 0.1, rel=0.01)


def test_a_stream_takes_a_plate_along_up_to_its_own_speed():
    wind = Wind(vx=0.1, vy=0.0, vz=2.0, c_normal=1.5)
    run = Run(cloth(POINTS, FACES, gravity=FREE, density=DENSITY), 1 / 1000, effects=(wind,))
    speed = run.trace(500, lambda now: now.v.mean(axis=0))
    rate = 0.5 * 1.2 * wind.c_normal / DENSITY  # dv/dt = rate (w - v)^2
    late = wind.vz / (1.0 + rate * wind.vz * np.arange(501) / 1000)
    assert speed[:, 2] == pytest.approx(wind.vz - late, abs=0.01 * wind.vz)
    assert np.abs(speed[:, :2]).max() < 1e-3


def test_a_sheet_that_shrank_along_its_threads_comes_to_rest_at_the_new_size():
    shrunk = Shrinkage(scale_u=0.95, scale_v=1.04)
    model = cloth(POINTS, FACES, gravity=FREE, density=DENSITY)
    run = Run(model, 1.0, effects=(shrunk,), iterations=200, warm_acceleration_g=0.0)
    for _ in range(3):
        run.put(v=np.zeros(3)).step()
    assert np.ptp(run.x, axis=0)[:2] / np.ptp(POINTS, axis=0)[:2] == pytest.approx([0.95, 1.04], rel=2e-3)
    assert run.solver.sheet.mass.numpy() == pytest.approx(model.particle_mass.numpy())
    assert model.tri_areas.numpy().sum() == pytest.approx(0.01, rel=1e-5)  # the model stays as it was given
    assert run.solver.sheet.triangle_area.numpy().sum() == pytest.approx(0.01 * 0.95 * 1.04, rel=1e-5)
    lengths = run.solver.sheet.edge_length.numpy()
    start, end = run.solver.sheet.edge.numpy().T
    assert np.linalg.norm(run.x[start] - run.x[end], axis=1) == pytest.approx(lengths, rel=3e-3)


def pulled(effects: tuple, along: int) -> float:
    """Strain of a sheet that hangs from the edge across axis `along`, over its length."""
    gravity = [0.0, 0.0, 0.0]
    gravity[along] = -G
    model = cloth(POINTS, FACES, gravity=tuple(gravity), density=4.0, tri_ke=100.0, tri_ka=0.0)
    hold(model, POINTS[:, along] > 0.0999)
    run = Run(model, 10.0, effects=effects, iterations=300, warm_acceleration_g=0.0)
    for _ in range(3):
        run.put(v=np.zeros(3)).step()
    return float(-run.x[POINTS[:, along] < 1e-9, along].mean() / 0.1)


@pytest.mark.parametrize("along", [0, 1])
def test_a_modulus_that_grows_with_strain_lets_a_hanging_sheet_stretch_as_its_law_says(along):
    """Load 4 G s = C e (1 + growth e) at height s over the lower edge, C = 2 mu, e the Green strain."""
    growth = 60.0
    heights = np.linspace(0.0, 0.1, 2001)
    load = 4.0 * G * heights
    green = (np.sqrt(1.0 + 4.0 * growth * load / 200.0) - 1.0) / (2.0 * growth)
    stiffer = np.mean(np.sqrt(1.0 + 2.0 * green) - 1.0)
    plain = np.mean(np.sqrt(1.0 + 2.0 * load / 200.0) - 1.0)
    assert pulled((), along) == pytest.approx(plain, rel=0.04)
    assert pulled((StrainStiffening(growth=growth),), along) == pytest.approx(stiffer, rel=0.04)
    assert stiffer < 0.7 * plain


@pytest.mark.parametrize("other", [StrainStiffening(growth=60.0), Shrinkage(scale_u=0.97, scale_v=1.02)])
def test_all_effects_go_along_the_warp_that_one_asks_for(other):
    turned = (AnisotropicStretch(ratio_warp_weft=4.0, warp=(0.0, 1.0, 0.0)), other)
    straight = (AnisotropicStretch(ratio_warp_weft=4.0), other)
    assert pulled(turned, 1) == pytest.approx(pulled(straight, 0), rel=1e-2)


def test_two_warp_directions_in_one_cloth_are_refused():
    both = tuple(AnisotropicStretch(ratio_warp_weft=2.0, warp=warp) for warp in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    with pytest.raises(ValueError, match=r"one warp direction.*0\.0, 1\.0, 0\.0"):
        Run(cloth(POINTS, FACES), 0.01, effects=both)
