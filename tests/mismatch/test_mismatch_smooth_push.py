"""The push without a name: against formulas, other simulations and differences; nothing where it is absent."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle

from sim1.cloth.effects import EFFECTS
from sim1.cloth.precise.newton import net_width
from sim1.cloth.precise.simulate import simulate
from sim1.cloth.precise.smooth_push import NUMBERS, pushes, smooth_push, smooth_push_slope
from sim1.cloth.precise.world import pack
from sim1.mismatch.fit import Fit
from sim1.mismatch.model_file import physics_of
from sim1.mismatch.search import baseline
from sim1.proof.baselines.residual import NAMES, SmoothPush, calibrated_z

PRESENT = tuple(0.05 * np.sin(1.0 + np.arange(NUMBERS)))  # pushes [Pa] and brakes [Pa s/m], none of them zero


@pytest.fixture(scope="module")
def bundle():
    return empty_bundle(duration_s=1.5)


def with_number(world, number, change):
    numbers = list(world.smooth_push or (0.0,) * NUMBERS)
    numbers[number] += change
    return replace(world, smooth_push=tuple(numbers))


def test_a_constant_push_adds_up_to_itself_times_the_area_and_a_graded_one_to_a_turn(scene):
    sheet = scene.sheet
    push, brake = pushes(sheet, [(0.0, 0.0, 2.0, *(0.0,) * 5, 3.0, *(0.0,) * 9)])[0]
    area, reach = sheet.vertex_area_m2, np.ptp(sheet.material_m[:, 0]) / 2
    graded = push[:, 2] - 2.0 * area  # 3 Pa at the far edge, -3 Pa at the near one
    middle = sheet.material_m[:, 0] - sheet.material_m[:, 0].min() - reach
    assert graded == pytest.approx(3.0 * area * middle / reach)
    assert (push[:, :2] == 0.0).all()
    assert (brake == 0.0).all()


def test_a_brake_answers_the_velocity(scene, world):
    cloth = pack(scene.sheet, [with_number(world, 3, 0.5)])
    out = np.zeros_like(scene.start)
    smooth_push(np.full_like(scene.start, 2.0), cloth.push, 0, out)
    assert out[:, 0] == pytest.approx(0.5 * 2.0 * scene.sheet.vertex_area_m2)  # a residual is inertia less forces
    assert (out[:, 1:] == 0.0).all()


def test_its_part_of_the_matrix_is_its_derivative(scene, world):
    cloth = pack(scene.sheet, [replace(world, smooth_push=PRESENT)])
    stream, rate = np.random.default_rng(0), 90.0
    v, way = (stream.standard_normal(scene.start.shape) for _ in range(2))
    band = np.zeros((v.size, 3 * net_width(scene.net) + 3))
    smooth_push_slope(cloth.push, rate, band)
    sides = np.zeros((2, *v.shape))
    for side, sign in zip(sides, (1, -1), strict=True):
        smooth_push(v + sign * rate * way, cloth.push, 0, side)
    assert (band[:, 0] * way.ravel()) == pytest.approx(((sides[0] - sides[1]) / 2).ravel(), rel=1e-9)
    assert (band[:, 1:] == 0.0).all()


@pytest.mark.parametrize("present", [(), PRESENT], ids=["absent", "present"])
def test_a_twin_says_what_another_simulation_would(scene, world, present):
    base, little = replace(world, smooth_push=present), 2e-2
    chosen = (0, 2, 5, 8, 11, 16)  # pushes and brakes of all three basis functions
    run = simulate(scene, [base, *(with_number(base, number, 1e-3 * little) for number in chosen)])
    for number, told in zip(chosen, run.markers_m[1:], strict=True):
        change = simulate(scene, [with_number(base, number, little)], near=run.rest_m).markers_m[0] - run.markers_m[0]
        off = np.sqrt(np.mean((1e3 * (told - run.markers_m[0]) - change) ** 2))
        assert off < 0.1 * np.sqrt(np.mean(change**2)) + 5e-7, NAMES[number]


def test_where_it_is_absent_there_is_nothing_to_compute_and_numbers_of_zero_change_nothing(scene, world):
    zero = replace(world, smooth_push=(0.0,) * NUMBERS)
    assert pack(scene.sheet, [world, world]).push.shape[0] == 0
    assert pack(scene.sheet, [world, zero]).push.shape == (2, 2, len(scene.start), 3)
    plain, other = (simulate(scene, [one]).markers_m for one in (world, zero))
    assert np.abs(plain - other).max() < 1e-9


def test_no_diagnosis_tries_it(world):
    assert SmoothPush.name not in EFFECTS
    values = {name: float(k) for k, name in enumerate(NAMES)}
    assert SmoothPush.alter(world, values).smooth_push == tuple(range(NUMBERS))


def test_a_calibrated_model_is_read_back_as_where_its_search_ended():
    bundle = empty_bundle(measured=False)  # places of the held vertices are fitted too
    plain = baseline(bundle)

    def written(z):
        nothing = {"a": np.zeros(1)}
        slopes = {"a": np.zeros((1, plain.count))}
        found = Fit(
            unknowns=plain,
            z=z,
            names=("a",),
            temper={"a": 1.0},
            residuals=nothing,
            slopes=slopes,
            mesh_off=nothing,
            stretch={"a": np.zeros(1, int)},
            converged=True,
        )
        return physics_of(bundle, found)

    z = 0.3 * np.sin(1.0 + np.arange(plain.count))
    model = written(z)
    again = written(calibrated_z(bundle, plain, model))
    assert again.bending_n_m.value == pytest.approx(model.bending_n_m.value)
    assert again.mesh == pytest.approx(model.mesh)
    # A bar's vertices lie on a line: turned about it they are where they were.
    assert np.array(again.grips[0]["places_m"]) == pytest.approx(np.array(model.grips[0]["places_m"]), abs=1e-9)
    assert not np.allclose(again.grips[0]["places_m"], written(np.zeros(plain.count)).grips[0]["places_m"])
