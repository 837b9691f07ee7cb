"""What the cell's solver makes of effects that act through the table, against theory."""

import numpy as np
import pytest
from avbd_sheets import RADIUS, G, Run, cloth, square_grid

from sim1.cloth.effects import Adhesion, AnisotropicFriction, Effect, StaticFriction

POINTS, FACES = square_grid(5, 5, 0.03)
ON_THE_TABLE = POINTS - POINTS.mean(axis=0) + np.array([0.0, 0.0, RADIUS])
DENSITY = 0.3
DT = 1.0 / 240.0
MU = 0.4


def lying(*effects: Effect, gravity: tuple[float, float, float] = (0.0, 0.0, -G), speed: tuple = (0, 0, 0)) -> Run:
    """A sheet on the table in a field of gravity that may lean."""
    model = cloth(ON_THE_TABLE, FACES, density=DENSITY, gravity=gravity, ground={"ke": 300.0, "kd": 0.2, "mu": MU})
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


def test_clinging_ends_at_its_reach():
    for reach, falls in ((1e-3, True), (4e-3, False)):
        run = lying(Adhesion(pressure=10.0 * DENSITY * G, reach=reach), gravity=(0.0, 0.0, G))
        run.put(x=ON_THE_TABLE + np.array([0.0, 0.0, 0.002])).step(60)
        assert (run.x[:, 2].min() > RADIUS + 0.01) == falls


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
    sticky = StaticFriction(ratio=2.0, stribeck_speed=1.0)
    speed = lying(sticky, speed=(1.5, 0.0, 0.0)).trace(60, lambda now: now.v[:, 0].mean())
    middle = 0.5 * (speed[20] + speed[40])
    expected = MU * G * (1.0 + np.exp(-(middle**2)))
    assert (speed[20] - speed[40]) / (20 * DT) == pytest.approx(expected, rel=0.03)


def test_each_axis_of_the_table_brakes_by_its_own_coefficient():
    uneven = AnisotropicFriction(mu_x=0.6, mu_y=0.2)
    along = braking(lying(uneven, speed=(3.0, 0.0, 0.0)))
    across = braking(lying(uneven, speed=(0.0, 3.0, 0.0)))
    oblique = braking(lying(uneven, speed=(30.0, 30.0, 0.0)))  # so fast that it hardly turns
    assert along[:2] == pytest.approx([0.6 * G, 0.0], abs=0.02 * G)
    assert across[:2] == pytest.approx([0.0, 0.2 * G], abs=0.02 * G)
    assert oblique[:2] == pytest.approx([0.6 * G / np.sqrt(2), 0.2 * G / np.sqrt(2)], rel=0.05)


def test_sticking_and_uneven_friction_act_together_in_either_order():
    both = (AnisotropicFriction(mu_x=0.6, mu_y=0.2), StaticFriction(ratio=1.5, stribeck_speed=100.0))
    for effects in (both, both[::-1]):
        assert braking(lying(*effects, speed=(3.0, 0.0, 0.0)))[0] == pytest.approx(1.5 * 0.6 * G, rel=0.02)


def test_an_effect_of_the_table_without_a_table_is_refused():
    with pytest.raises(ValueError, match="adhesion act on a table"):
        Run(cloth(ON_THE_TABLE, FACES, density=DENSITY), DT, effects=(Adhesion(pressure=1.0),))
