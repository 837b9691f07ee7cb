from dataclasses import replace

import numpy as np
import pytest
from avbd_sheets import DEVICE

from sim1.cloth.config import FRAME_S, GRAVITY_M_S2, CellConfig
from sim1.cloth.effects import EFFECTS, acts
from sim1.cloth.garment import checked_mesh, grid_towel
from sim1.cloth.model import build_model
from sim1.cloth.physics import ClothPhysics, Friction, Property
from sim1.cloth.world import ClothWorld, SimulationBroke, body_path
from sim1.stage import BadInput

VALUES = {
    "area_density_kg_m2": 0.3,
    "thickness_m": 0.002,
    "stretch_n_m": 400.0,
    "poisson": 0.3,
    "bending_n_m": 5e-5,
    "damping_s": 1e-3,
}
CLOTH = ClothPhysics(**{name: Property(value=value) for name, value in VALUES.items()})
STRIP = grid_towel(0.16, 0.08, 0.02)


def tool(x: float, y: float, z: float) -> np.ndarray:
    """Fingers down, opening along y."""
    pose = np.eye(4)
    pose[:3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
    pose[:3, 3] = x, y, z
    return pose


FOLDED = STRIP.rest_m * np.array([np.where(STRIP.rest_m[:, 0] > 0, -1.0, 1.0), *[np.ones(len(STRIP.rest_m))] * 2]).T
FOLDED[:, 2] = np.where(STRIP.rest_m[:, 0] > 0, 0.01, 0.004)
PARKED = np.stack([tool(0.3, 0.3, 0.4), tool(0.3, -0.3, 0.4)])


@pytest.fixture(scope="module")
def world() -> ClothWorld:
    return ClothWorld(STRIP, CLOTH, CellConfig(), device=DEVICE)


def run(world: ClothWorld, frames: int) -> np.ndarray:
    for _ in range(frames):
        world.step(world.tools, world.gaps_m)
    return world.garment_m


def test_cloth_in_the_air_falls_as_galileo_says(world):
    start = STRIP.rest_m + np.array([0, 0, 0.5])
    world.reset(start, PARKED, np.zeros(2))
    seconds = 2 * FRAME_S
    fallen = start[:, 2] - run(world, 2)[:, 2]
    step = FRAME_S / world.config.substeps  # implicit Euler falls one half step further
    assert fallen == pytest.approx(0.5 * GRAVITY_M_S2 * seconds * (seconds + step), rel=1e-3)


def test_self_contact_does_not_brake_cloth_that_falls_fast(world):
    start = STRIP.rest_m + np.array([0, 0, 1.0])
    world.reset(start, PARKED, np.zeros(2))
    run(world, 12)
    assert -world.garment_m_s[:, 2] == pytest.approx(GRAVITY_M_S2 * 12 * FRAME_S, rel=2e-3)


def test_cloth_rests_one_contact_radius_above_the_table(world):
    world.reset(STRIP.rest_m + np.array([0, 0, 0.01]), PARKED, np.zeros(2))
    heights = run(world, 12)[:, 2]
    assert heights == pytest.approx(world.config.contact_radius_m, abs=5e-5)


def test_same_start_gives_the_same_bytes(world):
    tilted = FOLDED + np.array([0, 0, 0.03])
    tilted[:, 2] += 0.3 * STRIP.rest_m[:, 0]
    world.reset(FOLDED, PARKED, np.zeros(2))  # what lay there before must not matter
    run(world, 4)
    world.reset(tilted, PARKED, np.zeros(2))
    first = run(world, 8)
    world.reset(tilted, PARKED, np.zeros(2))
    assert run(world, 8).tobytes() == first.tobytes()
    other = ClothWorld(STRIP, CLOTH, CellConfig(), device=DEVICE)
    other.reset(tilted, PARKED, np.zeros(2))
    assert run(other, 8).tobytes() == first.tobytes()


@pytest.mark.parametrize("mu", [0.2, 0.6])
def test_sliding_cloth_is_braked_by_coulomb_friction_of_the_table(mu):
    physics = ClothPhysics(
        **{name: Property(value=value) for name, value in VALUES.items()}, friction=Friction(table=Property(value=mu))
    )
    sliding = ClothWorld(STRIP, physics, CellConfig(self_contact=False), device=DEVICE)
    sliding.reset(STRIP.rest_m + np.array([0, 0, sliding.config.contact_radius_m]), PARKED, np.zeros(2))
    run(sliding, 3)  # the sheet sinks into the table's penalty, by micrometres: then the table carries its weight
    speed = 1.0
    sliding.push(np.array([speed, 0.0, 0.0]))
    run(sliding, 3)
    lost = speed - sliding.garment_m_s[:, 0].mean()
    assert lost == pytest.approx(mu * GRAVITY_M_S2 * 3 * FRAME_S, rel=0.01)


def test_pinched_strip_is_lifted_and_does_not_slip(world):
    world.reset(
        STRIP.rest_m + np.array([0, 0, 0.002]), np.stack([tool(-0.06, 0.0, 0.1), PARKED[1]]), np.array([0.036, 0.036])
    )

    def to(pose: np.ndarray, gap: float, frames: int) -> None:
        start, opened = world.tools[0].copy(), world.gaps_m[0]
        for share in np.linspace(0, 1, frames + 1)[1:]:
            between = pose.copy()
            between[:3, 3] = start[:3, 3] + share * (pose[:3, 3] - start[:3, 3])
            gaps = np.array([opened + share * (gap - opened), 0.036])
            world.step(np.stack([between, PARKED[1]]), gaps)

    to(tool(-0.06, 0.0, 0.0005), 0.036, 12)
    to(tool(-0.06, 0.0, 0.0005), 0.0, 12)
    to(tool(-0.06, 0.0, 0.20), 0.0, 20)
    held = int(np.argmax(world.garment_m[:, 2]))
    local = (world.garment_m - world.tools[0][:3, 3]) @ world.tools[0][:3, :3]
    between_pads = (np.abs(local[:, 1]) < 0.004) & (np.abs(local[:, 2]) < 0.011) & (np.abs(local[:, 0] + 0.03) < 0.03)
    to(tool(-0.06, 0.0, 0.20), 0.0, 20)
    after = (world.garment_m - world.tools[0][:3, 3]) @ world.tools[0][:3, :3]
    assert between_pads.any()
    assert np.linalg.norm(after - local, axis=1)[between_pads].max() < 0.005
    assert world.garment_m[held, 2] > 0.17
    assert world.garment_m[:, 2].min() > 0.02  # the whole strip hangs in the air


def test_hanging_cloth_stretches_under_its_own_weight():
    soft = CLOTH.with_values(stretch_n_m=50.0, poisson=0.0, damping_s=5e-3)
    hanging = ClothWorld(STRIP, soft, CellConfig(self_contact=False, iterations=150), device=DEVICE)
    up = STRIP.rest_m[:, [2, 1, 0]] + np.array([0, 0, 0.5])  # its long side along z
    hanging.reset(up, PARKED, np.zeros(2))
    top = up[:, 2] > up[:, 2].max() - 1e-6
    hanging.fix(top)
    run(hanging, 25)
    length = float(np.ptp(STRIP.rest_m[:, 0]))
    expected = 0.3 * GRAVITY_M_S2 * length**2 / (2 * 50.0)  # weight below each point, over the stiffness
    stretched = float(np.ptp(hanging.garment_m[:, 2])) - length
    assert stretched == pytest.approx(expected, rel=0.1)


def test_mass_is_area_times_density():
    model = build_model(STRIP, CLOTH, CellConfig(), (0.8, 1.2))
    assert model.particle_mass.numpy().sum() == pytest.approx(0.16 * 0.08 * 0.3)


def test_a_position_that_is_not_finite_is_refused_and_one_that_flies_off_is_reported(world):
    with pytest.raises(ValueError, match="finite"):
        world.reset(np.full_like(STRIP.rest_m, np.nan), PARKED, np.zeros(2))
    far = STRIP.rest_m.copy()
    far[5] += 1e4
    world.reset(far, PARKED, np.zeros(2))
    with pytest.raises(SimulationBroke) as error:
        world.step(PARKED, np.zeros(2))
    assert error.value.frame == 1


def test_fingers_move_evenly_and_never_closer_than_their_pads():
    config = CellConfig(substeps=4)
    moved = PARKED.copy()
    moved[0, 0, 3] += 0.04
    path = body_path(PARKED, moved, np.array([0.02, 0.0]), np.array([0.0, 0.0]), config)
    assert np.diff(path[:, 0, 0]) == pytest.approx(0.01, abs=1e-6)
    apart = np.linalg.norm(path[:, 1, :3] - path[:, 2, :3], axis=1) - config.finger_thickness_m
    assert apart[0] == pytest.approx(0.02, abs=1e-6)
    assert apart[-1] == pytest.approx(config.closed_gap_m, abs=1e-6)


def test_a_mesh_with_a_face_without_area_is_refused():
    flat = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], float)
    with pytest.raises(BadInput, match="area"):
        checked_mesh(flat, np.array([[0, 1, 2]]), flat)


def test_what_broke_first_is_named_and_the_last_states_are_kept(tmp_path):
    path = tmp_path / "broken.npz"
    world = ClothWorld(STRIP, CLOTH, CellConfig(self_contact=False), broken_to=path, device=DEVICE)
    world.reset(STRIP.rest_m + np.array([0, 0, 0.3]), PARKED, np.zeros(2))
    run(world, 2)
    stiffness = world._solver.sheet.hinge_stiffness
    spoiled = stiffness.numpy()
    spoiled[3] = np.nan
    stiffness.assign(spoiled)
    with pytest.raises(SimulationBroke, match=r"'bending'.*last 3 frames.*broken\.npz") as error:
        run(world, 1)
    assert error.value.vertex in world._solver.sheet.hinge.numpy()[3]
    with np.load(path) as kept:
        assert kept["garment_m"].shape == (3, *STRIP.rest_m.shape)
        assert '"max_strain": 0.05' in str(kept["parameters"])


ACTED = {
    "air_drag": {"c_normal": 1.5, "c_tangential": 0.05},
    "added_mass": {"mass": 0.05},
    "adhesion": {"pressure": 1.0, "reach": 0.008},
    "anisotropic_bending": {"ratio_warp_weft": 2.0},
    "anisotropic_friction": {"mu_x": 0.5, "mu_y": 0.3},
    "anisotropic_stretch": {"ratio_warp_weft": 1.5},
    "bending_hysteresis": {"moment": 5e-5, "slip_curvature": 4.0},
    "plastic_crease": {"yield_curvature": 20.0, "retained": 0.5},
    "rest_curvature": {"kappa_u": 2.0, "kappa_v": 0.0},
    "shrinkage": {"scale_u": 0.98, "scale_v": 1.01},
    "static_friction": {"ratio": 1.5, "stribeck_speed": 0.01},
    "strain_stiffening": {"growth": 50.0},
    "wind": {"c_normal": 1.3, "vx": 0.2, "vy": 0.0, "vz": 0.0},
}


def thrown(world: ClothWorld) -> np.ndarray:
    """Where a folded strip has come to that was thrown over the table."""
    world.reset(FOLDED, PARKED, np.zeros(2))
    world.push(np.array([0.3, 0.0, 0.0]))
    return run(world, 5)


def with_named(*names: str) -> ClothWorld:
    entries = tuple(
        {"name": name, "parameters": {key: {"value": value} for key, value in ACTED[name].items()}} for name in names
    )
    return ClothWorld(STRIP, replace(CLOTH, effects=entries), CellConfig(), device=DEVICE)


def test_every_effect_that_the_solver_acts_is_acted_here():
    assert set(ACTED) == {name for name, effect in EFFECTS.items() if acts(effect)}


@pytest.mark.parametrize("name", ACTED)
def test_a_world_with_named_physics_goes_another_way_and_the_same_one_after_a_reset(world, name):
    """In the cell's own settings: recorded launches, wrinkles below the mesh, layers that collide."""
    named, plain = with_named(name), thrown(world)
    first = thrown(named)
    assert thrown(named).tobytes() == first.tobytes()
    assert 1e-5 < np.abs(first - plain).max() < 0.1


def test_a_world_with_all_named_physics_repeats_itself_after_a_reset_and_for_any_order_of_names():
    world = with_named(*ACTED)
    first = thrown(world)
    assert thrown(world).tobytes() == first.tobytes()
    assert thrown(with_named(*reversed(ACTED))).tobytes() == first.tobytes()
