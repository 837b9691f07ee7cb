import numpy as np
import pytest
from avbd_sheets import G, cloth, equilibrium, hold, make_plate, square_grid, triangle_grid
from scipy.integrate import solve_bvp

DENSITY = 0.2


@pytest.mark.parametrize("poisson", [0.0, 0.3])
def test_a_hanging_strip_stretches_by_weight_times_length_over_twice_its_stiffness(poisson):
    points, faces = square_grid(3, 25, 0.02)
    length = float(np.ptp(points[:, 1]))
    stretch = 0.004
    stiffness = DENSITY * G * length / (2.0 * stretch)  # E h [N/m]
    mu = stiffness / (2.0 * (1.0 + poisson))
    lam = stiffness * poisson / (1.0 - poisson**2)  # plane stress
    model = cloth(points, faces, density=DENSITY, tri_ke=mu, tri_ka=lam, gravity=(0.0, -G, 0.0))
    hold(model, points[:, 1] > length - 1e-6)
    x = equilibrium(model, 3000)
    low = points[:, 1] < 1e-6
    assert points[low, 1].mean() - x[low, 1].mean() == pytest.approx(stretch * length, rel=0.02)


class Overhang:
    """A plate clamped along one edge, wide against its overhang, of regular triangles of `cells` rows; bends by its weight.

    Two rows are held; a hinge stands for half a row on either side, so the clamp is half way between the two.
    """

    def __init__(self, cells: int, width_in_overhangs: float, weight_over_rigidity: float) -> None:
        row = 0.2 / cells
        edge = row / np.sqrt(0.75)
        self.points, self.faces = triangle_grid(0.2 * width_in_overhangs, 0.2 + row, edge)
        self.clamp = 0.5 * row
        self.length = 0.2 + 0.5 * row
        self.rigidity = DENSITY * G * self.length**3 / weight_over_rigidity
        stiff = 300.0 * DENSITY * G * self.length  # the weight stretches it by 0.17 % at most
        self.model = cloth(self.points, self.faces, density=DENSITY, tri_ke=stiff / 2.0, tri_ka=0.0)
        make_plate(self.model, self.points, self.faces, self.rigidity)
        hold(self.model, self.points[:, 1] < 1.5 * row)

    def tip(self, iterations: int = 2000) -> tuple[float, float]:
        """Reach and drop of the free edge, over the length."""
        x = equilibrium(self.model, iterations)
        free = self.points[:, 1] > self.points[:, 1].max() - 1e-6
        return (x[free, 1].mean() - self.clamp) / self.length, -x[free, 2].mean() / self.length


def elastica(weight_over_rigidity: float) -> tuple[float, float]:
    """Reach and drop of the end of a heavy elastica clamped level, over its length: theta'' = -(q L^3 / D) (1 - s) cos theta."""
    s = np.linspace(0.0, 1.0, 101)
    solution = solve_bvp(
        lambda at, y: np.stack([y[1], -weight_over_rigidity * (1.0 - at) * np.cos(y[0])]),
        lambda start, end: np.array([start[0], end[1]]),
        s,
        np.stack([s, 1.0 - s]),
        tol=1e-6,
    )
    along = np.linspace(0.0, 1.0, 2001)
    angle = solution.sol(along)[0]
    return float(np.trapezoid(np.cos(angle), along)), float(np.trapezoid(np.sin(angle), along))


@pytest.mark.parametrize("cells", [6, 8, 10])
def test_an_overhanging_plate_bends_down_by_q_l4_over_8_d(cells):
    load = 0.1
    _, drop = Overhang(cells, 2.0, load).tip()
    assert drop == pytest.approx(load / 8.0, rel=0.03)


@pytest.mark.parametrize("load", [3.0, 10.0, 30.0])
def test_an_overhanging_plate_falls_into_the_shape_of_the_heavy_elastica(load):
    reach, drop = Overhang(10, 1.5, load).tip()
    expected_reach, expected_drop = elastica(load)
    assert drop == pytest.approx(expected_drop, rel=0.03)
    assert reach == pytest.approx(expected_reach, rel=0.03)


def test_the_elastica_of_a_small_load_is_the_beam_of_the_textbook():
    assert elastica(0.01)[1] == pytest.approx(0.01 / 8.0, rel=1e-3)
