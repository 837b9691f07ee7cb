import numpy as np
import pytest
from avbd_elements import Elements, downhill, fold_angle, membrane_energy, woven_energy
from avbd_sheets import Run, cloth, triangle_grid

from sim1.cloth.effects.anisotropic_stretch import AnisotropicStretch
from sim1.cloth.effects.strain_stiffening import StrainStiffening

MU, LAMBDA, BENDING = 120.0, 80.0, 3e-3
EDGE = 0.05
POINTS, FACES = triangle_grid(0.2, 0.13, EDGE)


@pytest.fixture(scope="module")
def folded_rest() -> np.ndarray:
    """A sheet whose rest shape is itself bent and uneven."""
    uneven = POINTS + 0.1 * EDGE * np.random.default_rng(3).standard_normal(POINTS.shape)
    return np.float32(uneven).astype(float)


@pytest.fixture(scope="module")
def sheet(folded_rest) -> Run:
    return Run(cloth(folded_rest, FACES, tri_ke=MU, tri_ka=LAMBDA, edge_ke=BENDING), 0.01)


def deformed(rest: np.ndarray, squeeze: float, seed: int) -> np.ndarray:
    """Moved, turned, scaled in its plane by `squeeze`, and crumpled by a fifth of an edge."""
    random = np.random.default_rng(seed)
    turn = np.linalg.qr(random.standard_normal((3, 3)))[0]
    turn *= np.linalg.det(turn)
    crumpled = rest * np.array([squeeze, squeeze, 1.0]) + 0.2 * EDGE * random.standard_normal(rest.shape)
    return np.float32(crumpled @ turn.T + 0.02 * random.standard_normal(3)).astype(float)


DEFORMATIONS = pytest.mark.parametrize(("squeeze", "seed"), [(1.0, 0), (1.2, 1), (0.9, 2), (0.5, 3)])


def assert_close(force: np.ndarray, expected: np.ndarray, share: float = 1e-3) -> None:
    assert np.abs(force - expected).max() < share * np.abs(expected).max()


@DEFORMATIONS
def test_membrane_force_is_the_slope_of_the_st_venant_kirchhoff_energy(sheet, folded_rest, squeeze, seed):
    x = deformed(folded_rest, squeeze, seed)
    elements = Elements("membrane", sheet)
    force, _ = elements.at(x)
    for corners, found in zip(elements.corners, force):
        rest = folded_rest[corners]
        assert_close(found, downhill(lambda p, r=rest: membrane_energy(p, r, MU, LAMBDA), x[corners]))


@DEFORMATIONS
def test_hinge_force_is_the_slope_of_half_k_angle_from_rest_squared(sheet, folded_rest, squeeze, seed):
    x = deformed(folded_rest, squeeze, seed)
    elements = Elements("hinge", sheet)
    force, _ = elements.at(x)
    expected = []
    for corners in elements.corners:
        rest = folded_rest[corners]
        stiffness = BENDING * np.linalg.norm(rest[3] - rest[2])

        def energy(p: np.ndarray, k: float = stiffness, rest_angle: float = fold_angle(rest)) -> float:
            return 0.5 * k * np.angle(np.exp(1j * (fold_angle(p) - rest_angle))) ** 2

        expected.append(downhill(energy, x[corners]))
    assert_close(force, np.array(expected))


@pytest.mark.parametrize("multiplier_n", [0.0, 2.0])
def test_strain_limit_force_is_the_slope_of_the_augmented_lagrangian_and_pulls_only(sheet, folded_rest, multiplier_n):
    x = deformed(folded_rest, 1.1, 5)
    penalty = 1.0e4
    now = sheet.solver.now
    now.edge_force.fill_(multiplier_n)
    now.edge_stiffness.fill_(penalty)
    elements = Elements("limit", sheet, largest_strain=0.05)
    force, _ = elements.at(x)
    pulling = 0
    for corners, found in zip(elements.corners, force):
        allowed = 1.05 * np.linalg.norm(np.subtract(*folded_rest[corners]))

        def energy(p: np.ndarray, longest: float = allowed) -> float:
            pull = multiplier_n + penalty * (np.linalg.norm(p[0] - p[1]) - longest)
            return 0.5 * max(pull, 0.0) ** 2 / penalty

        pulling += energy(x[corners]) > 0.0
        assert np.abs(found - downhill(energy, x[corners])).max() < 1e-3 * penalty * 0.1 * EDGE
    assert 0.2 * len(force) < pulling < len(force)


@pytest.mark.parametrize("kind", ["membrane", "hinge", "limit"])
@DEFORMATIONS
def test_blocks_are_symmetric_and_positive_semidefinite(sheet, folded_rest, kind, squeeze, seed):
    sheet.solver.now.edge_force.fill_(1.0e3)
    _, block = Elements(kind, sheet).at(deformed(folded_rest, squeeze, seed))
    size = np.abs(block).max()
    assert size > 0.0
    assert np.abs(block - block.swapaxes(-1, -2)).max() < 1e-5 * size
    assert np.linalg.eigvalsh(block).min() > -1e-5 * size


def test_membrane_block_of_a_stretched_triangle_is_the_curvature_of_its_energy(sheet, folded_rest):
    stretched = folded_rest * 1.1
    elements = Elements("membrane", sheet)
    _, block = elements.at(stretched)
    for corners, found in zip(elements.corners, block):
        rest = folded_rest[corners]

        def pull(corner: np.ndarray, p: np.ndarray = stretched[corners], r: np.ndarray = rest) -> np.ndarray:
            return downhill(lambda q: membrane_energy(q, r, MU, LAMBDA), np.concatenate([corner[None], p[1:]]))[0]

        by = 1e-5
        columns = [
            (pull(stretched[corners[0]] - e) - pull(stretched[corners[0]] + e)) / (2 * by) for e in by * np.eye(3)
        ]
        assert_close(found[0], np.stack(columns, axis=1), share=2e-3)


@pytest.mark.parametrize("kind", ["membrane", "hinge", "limit"])
@DEFORMATIONS
def test_internal_forces_neither_push_nor_turn_the_sheet(sheet, folded_rest, kind, squeeze, seed):
    sheet.solver.now.edge_force.fill_(1.0e3)
    x = deformed(folded_rest, squeeze, seed)
    elements = Elements(kind, sheet)
    force, _ = elements.at(x)
    arms = x[elements.corners] - x.mean(axis=0)
    for element, arm in zip(force, arms):
        total = np.abs(element).sum()
        reach = np.abs(arm).max()
        assert np.abs(element.sum(axis=0)).max() <= 1e-5 * total
        assert np.abs(np.cross(arm, element).sum(axis=0)).max() <= 1e-5 * total * reach


def test_a_fold_turned_past_180_degrees_is_followed_and_not_taken_for_a_fold_to_the_other_side():
    points = np.array([[0.0, 0, 0], [0.1, 0.1, 0], [0.1, 0, 0], [0, 0.1, 0]])
    run = Run(cloth(points, np.array([[0, 2, 3], [1, 3, 2]]), edge_ke=BENDING), 0.01)
    elements = Elements("hinge", run)
    apex = int(elements.corners[0, 1])
    c, d = points[elements.corners[0, 2]], points[elements.corners[0, 3]]
    axis = (d - c) / np.linalg.norm(d - c)
    arm = points[apex] - 0.5 * (c + d)
    sizes = []
    for turned in np.linspace(0.0, np.radians(200.0), 21):
        x = points.copy()
        x[apex] = 0.5 * (c + d) + np.cos(turned) * arm + np.sin(turned) * np.cross(axis, arm)
        force, _ = elements.at(x)
        sizes.append(np.linalg.norm(force[0, 1]))
    arm_length = np.linalg.norm(arm)
    expected = BENDING * np.linalg.norm(d - c) * np.linspace(0.0, np.radians(200.0), 21) / arm_length
    assert sizes == pytest.approx(expected, rel=1e-3, abs=1e-9)


RIGHT = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]])


def woven(ratio: float, growth: float, lam: float, compression_share: float, angle: float = 0.0) -> Elements:
    """One triangle of a weave with warp at this angle to x."""
    warp = (float(np.cos(angle)), float(np.sin(angle)), 0.0)
    effects = (AnisotropicStretch(ratio_warp_weft=ratio, warp=warp), StrainStiffening(growth=growth))
    model = cloth(RIGHT, np.array([[0, 1, 2]]), tri_ke=100.0, tri_ka=lam)
    return Elements("membrane", Run(model, 0.01, effects=effects, compression_share=compression_share))


@pytest.mark.parametrize(
    ("ratio", "growth", "angle"), [(1.0, 60.0, 0.0), (4.0, 0.0, 0.0), (0.25, 60.0, 0.0), (4.0, 60.0, 0.5)]
)
@pytest.mark.parametrize("compression_share", [1.0, 0.02])
def test_membrane_force_of_a_weave_is_the_slope_of_the_least_energy_that_wrinkles_leave(
    ratio, growth, angle, compression_share
):
    c, s = np.cos(angle), np.sin(angle)
    along = RIGHT @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    law = np.diag([300.0 * np.sqrt(ratio), 300.0 / np.sqrt(ratio), 100.0])
    law[0, 1] = law[1, 0] = 100.0
    element = woven(ratio, growth, 100.0, compression_share, angle)
    random = np.random.default_rng(7)
    for _ in range(40):
        x = RIGHT @ np.linalg.qr(random.standard_normal((3, 3)))[0] + 0.006 * random.standard_normal((3, 3))
        x = np.float32(x).astype(float)
        assert_close(
            element.at(x)[0][0],
            downhill(lambda p: woven_energy(p, along, law, compression_share, growth), x),
            share=3e-3,
        )


@pytest.mark.parametrize("lam", [0.0, 100.0])
@pytest.mark.parametrize("compression_share", [1.0, 0.02])
@pytest.mark.parametrize("ratio", [1.0, 4.0, 0.25])
def test_a_closed_round_of_stretching_and_squeezing_gives_no_work(lam, compression_share, ratio):
    element = woven(ratio, 0.0, lam, compression_share)
    c, s = np.cos(0.5), np.sin(0.5)  # oblique to the threads
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    up, full = np.linspace(0.0, 0.05, 101), np.full(101, 0.05)
    stretch = np.concatenate([up, full, up[::-1], 0.0 * up])
    squeeze = np.concatenate([0.0 * up, up, full, up[::-1]])
    states = [RIGHT @ turn.T @ np.diag([1.0 + a, 1.0 - b, 1.0]) @ turn for a, b in zip(stretch, squeeze)]
    forces = [element.at(x)[0][0] for x in states]
    work = sum(0.5 * ((f0 + f1) * (x1 - x0)).sum() for x0, x1, f0, f1 in zip(states, states[1:], forces, forces[1:]))
    stored = membrane_energy(states[100], RIGHT, 100.0, lam)
    assert abs(work) < 1e-3 * stored
