"""What the cell's solver makes of effects that act through the table, against theory."""

import newton
import numpy as np
import pytest
from avbd_sheets import RADIUS, G, Run, cloth, square_grid
from scipy.integrate import solve_ivp

from sim1.cloth.effects import Effect
from sim1.cloth.effects.adhesion import Adhesion
from sim1.cloth.effects.anisotropic_friction import AnisotropicFriction
from sim1.cloth.effects.static_friction import StaticFriction

POINTS, FACES = square_grid(5, 5, 0.03)
ON_THE_TABLE = POINTS - POINTS.mean(axis=0) + np.array([0.0, 0.0, RADIUS])
DENSITY = 0.3
DT = 1.0 / 240.0
MU = 0.4


def lying(
    *effects: Effect, gravity: tuple[float, float, float] = (0.0, 0.0, -G), speed: tuple = (0, 0, 0), mu: float = MU
) -> Run:
    """A sheet on the table in a field of gravity that may lean."""
    model = cloth(ON_THE_TABLE, FACES, density=DENSITY, gravity=gravity, ground={"ke": 300.0, "kd": 0.2, "mu": mu})
    run = Run(model, DT, touching=True, effects=effects, table=0, iterations=20, friction_speed_m_s=2e-3)
    return run.put(v=np.array(speed, float))


def braking(run: Run) -> np.ndarray:
    """Deceleration (3,) in the mean [m/s^2], once the sheet has settled on the table."""
    speed = run.trace(48, lambda now: now.v.mean(axis=0))
    return (speed[8] - speed[48]) / (40 * DT)


@pytest.mark.parametrize(("pressure", "holds"), [(1.5 * DENSITY * G, True), (0.5 * DENSITY * G, False), (0.0, False)])
def test_a_sheet_under_a_table_hangs_where_it_clings_with_more_than_its_weight(pressure, holds):
    run = lying(Adhesion(pressure=pressure, reach=2e-3), gravity=(0.0, 0.0, G)).step(120)
    assert (run.x[:, 2].max() < RADIUS + 1e-3) == holds


def test_clinging_presses_and_so_brakes():
    braked = braking(lying(Adhesion(pressure=3.0), speed=(3.0, 0.0, 0.0)))
    assert braked[0] == pytest.approx(MU * (G + 3.0 / DENSITY), rel=0.03)


@pytest.mark.parametrize("share", [0.25, 0.5, 0.9, 1.1])
@pytest.mark.parametrize("full_surface", [False, True])
def test_clinging_fades_out_over_its_reach_whatever_contacts_are_looked_for(share, full_surface):
    cling = Adhesion(pressure=3.0, reach=4e-3)
    run = lying(cling, gravity=(0.0, 0.0, 0.0))
    run.pipeline = newton.CollisionPipeline(
        run.model, soft_contact_gap=0.005, enable_rigid_soft_full_surface_contact=full_surface
    )
    run.contacts = run.pipeline.contacts()
    run.put(x=ON_THE_TABLE + np.array([0.0, 0.0, share * cling.reach])).step()
    corners = run.contacts.soft_contact_indices.numpy()[: int(run.contacts.soft_contact_count.numpy()[0])]
    assert (corners[:, 1] >= 0).any() == full_surface
    pulled = cling.pressure / DENSITY * max(1.0 - share, 0.0)
    assert -run.v[:, 2].mean() / DT == pytest.approx(pulled, rel=1e-3, abs=1e-6)


def slope(rise: float) -> tuple[float, float, float]:
    return (G * np.sin(np.arctan(rise)), 0.0, -G * np.cos(np.arctan(rise)))


def test_a_sheet_that_sticks_stays_where_one_that_slides_goes_on():
    sticky, steep = StaticFriction(ratio=1.6, stribeck_speed=0.05), slope(1.3 * MU)
    resting = lying(sticky, gravity=steep).step(120)
    sliding = lying(sticky, gravity=steep, speed=(0.5, 0.0, 0.0)).step(120)
    without = lying(gravity=steep).step(120)
    assert np.abs(resting.v).max() < 2e-3
    gained = 0.5 * (G * np.sin(np.arctan(1.3 * MU)) - MU * G * np.cos(np.arctan(1.3 * MU)))
    assert sliding.v[:, 0].mean() == pytest.approx(0.5 + gained, rel=0.02)
    assert without.v[:, 0].mean() == pytest.approx(gained, rel=0.05)


def test_friction_between_rest_and_slide_is_stribecks():
    sticky = StaticFriction(ratio=2.0, stribeck_speed=0.3)
    speed = lying(sticky, speed=(0.8, 0.0, 0.0)).trace(30, lambda now: now.v[:, 0].mean())[8:]

    def slowed(_: float, v: np.ndarray) -> np.ndarray:
        return -MU * G * (1.0 + np.exp(-((v / sticky.stribeck_speed) ** 2)))

    seconds = DT * np.arange(len(speed))
    expected = solve_ivp(slowed, (0.0, seconds[-1]), speed[:1], t_eval=seconds, rtol=1e-8).y[0]
    assert speed == pytest.approx(expected, abs=0.02 * speed[0])
    assert 0.0 < speed[-1] < sticky.stribeck_speed < speed[0]


def test_each_axis_of_the_table_brakes_by_its_own_coefficient():
    uneven = AnisotropicFriction(mu_x=0.6, mu_y=0.2)
    along = braking(lying(uneven, speed=(3.0, 0.0, 0.0)))
    across = braking(lying(uneven, speed=(0.0, 3.0, 0.0)))
    oblique = braking(lying(uneven, speed=(30.0, 30.0, 0.0)))  # so fast that it hardly turns
    assert along[:2] == pytest.approx([0.6 * G, 0.0], abs=0.02 * G)
    assert across[:2] == pytest.approx([0.0, 0.2 * G], abs=0.02 * G)
    assert oblique[:2] == pytest.approx([0.6 * G / np.sqrt(2), 0.2 * G / np.sqrt(2)], rel=0.05)


def test_the_table_rubs_by_both_coefficients_whatever_its_own_is():
    for mu in (0.0, 2.0):
        along = braking(lying(AnisotropicFriction(mu_x=0.6, mu_y=0.2), speed=(3.0, 0.0, 0.0), mu=mu))
        assert along[0] == pytest.approx(0.6 * G, abs=0.02 * G)


def test_sticking_and_uneven_friction_act_together_in_either_order():
    uneven, sticky = AnisotropicFriction(mu_x=0.6, mu_y=0.2), StaticFriction(ratio=1.6, stribeck_speed=0.05)
    for effects, holds in (((uneven, sticky), True), ((sticky, uneven), True), ((uneven,), False), ((sticky,), False)):
        speed = np.abs(lying(*effects, gravity=slope(0.8)).step(120).v).max()
        assert (speed < 2e-3) == holds


def test_an_effect_of_the_table_without_a_table_is_refused():
    with pytest.raises(ValueError, match="adhesion act on a table"):
        Run(cloth(ON_THE_TABLE, FACES, density=DENSITY), DT, effects=(Adhesion(pressure=1.0),))
