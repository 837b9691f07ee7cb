import json
from dataclasses import replace

import numpy as np
import pytest
import torch
from motion_synthetic import a_demo

from sim1.motion.fitting import fit_model, held_apart, jerk
from sim1.motion.interpolant import ENDS, interpolate
from sim1.motion.model import read_model, sliced, transition
from sim1.motion.network import MotionTransformer, signal_and_noise
from sim1.motion.placement import planar
from sim1.motion.pool import read_pool, write_pool
from sim1.motion.poses import TOKEN_SIZE, joined
from sim1.motion.stage import MotionModelConfig, check_motion_model, motion_model
from sim1.motion.training import denoising_loss, loss_from_noise, squared_error, tensors, trivial_from_noise
from sim1.motion.transitions import (
    HISTORY_COUNT,
    augmented,
    bank_of,
    moving_frames,
    outlook,
    principal_shapes,
    residual_scale,
    transitions_of,
)
from sim1.stage import BadInput

SMALL = MotionModelConfig(step_count=300, bank_count=128, width=32, layer_count=2)


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pool")
    rng = np.random.default_rng(5)
    write_pool(folder, [part for index in range(4) for part in a_demo(f"{index:04d}", rng, 3 * index)])
    out = tmp_path_factory.mktemp("model")
    facts = motion_model({"segment_pool": {"sheet": folder}}, out, SMALL)
    return folder, out, facts


def test_transitions_start_and_end_at_the_poses_of_their_neighbours(pool):
    reach, back = transitions_of(pool)[:2]
    np.testing.assert_allclose(reach.path.position_m[-1], pool[1].path.position_m[0], atol=1e-3)
    np.testing.assert_allclose(back.path.position_m[0], pool[1].path.position_m[-1], atol=1e-3)
    assert len(reach.history) == len(back.history) == HISTORY_COUNT
    np.testing.assert_array_equal(back.history.position_m[-1], back.path.position_m[0])


def test_waiting_is_no_part_of_a_transition(pool):
    path = pool[0].path
    waiting = joined(*[path[:1]] * 9, path, *[path[-1:]] * 20)
    start, end = moving_frames(waiting)
    assert 8 <= start <= 12
    assert len(waiting) - 24 <= end <= len(waiting) - 19


def test_augmented_transitions_keep_their_speed_and_history(pool):
    original = transitions_of(pool)[1]
    rng = np.random.default_rng(0)
    speeds = np.linalg.norm(np.diff(original.path.position_m, axis=0), axis=-1)
    for _ in range(20):
        varied = augmented(original, rng)
        varied_speeds = np.linalg.norm(np.diff(varied.path.position_m, axis=0), axis=-1)
        assert varied_speeds.max() <= speeds.max() + 1e-12
        np.testing.assert_allclose(varied.history.position_m[-1], varied.path.position_m[0])


def test_what_is_learned_does_not_depend_on_the_place_on_the_table(trained):
    folder, out, _ = trained
    model, item = read_model(out), transitions_of(read_pool(folder))[1]
    elsewhere = planar(np.array([0.07, -0.04]), 0.6, np.zeros(3))
    here = transition(model, item.history, item.after, 35, np.random.default_rng(3))
    there = transition(model, item.history.moved(elsewhere), item.after.moved(elsewhere), 35, np.random.default_rng(3))
    np.testing.assert_allclose(there.position_m, here.moved(elsewhere).position_m, atol=1e-5)
    np.testing.assert_allclose(there.rotation, here.moved(elsewhere).rotation, atol=1e-5)


def test_an_outlook_goes_from_where_the_tools_are_to_where_they_go(pool):
    path = pool[0].path
    seen = path.moved(np.linalg.inv(outlook(path[:1], path[-1:]))).position_m[[0, -1]].mean(axis=1)
    np.testing.assert_allclose(seen[0, :2], -seen[1, :2], atol=1e-12)
    assert seen[1, 0] > 0
    assert seen[1, 1] == pytest.approx(0, abs=1e-12)


def test_principal_shapes_hold_the_residuals_and_no_shaking(pool):
    bank = bank_of(transitions_of(pool), 64, 16, np.random.default_rng(0))
    scale = residual_scale(bank.residual)
    shapes = principal_shapes(bank.residual, scale, 20)
    np.testing.assert_allclose(shapes @ shapes.T, np.eye(20), atol=1e-9)
    rows = (bank.residual / scale).reshape(64, -1)
    assert np.linalg.norm(rows - rows @ shapes.T @ shapes) < 0.1 * np.linalg.norm(rows)
    shaking = np.random.default_rng(1).standard_normal(rows.shape)
    assert np.linalg.norm(shaking @ shapes.T) < 0.3 * np.linalg.norm(shaking)


def test_the_schedule_preserves_variance_and_ends_clean():
    signal, noise = signal_and_noise(torch.linspace(0, 1, 11))
    torch.testing.assert_close(signal**2 + noise**2, torch.ones(11))
    assert float(noise[0]) == 0
    assert float(signal[-1]) == pytest.approx(0, abs=1e-6)


def test_a_token_hears_of_its_own_noise_level():
    torch.manual_seed(0)
    network = MotionTransformer(32, 1, 8, 2)
    torch.nn.init.normal_(network.out.weight)
    noisy, base = torch.randn(1, 8, 20), torch.randn(1, 8, 20)
    history, after = torch.randn(1, HISTORY_COUNT, 20), torch.randn(1, ENDS, 20)
    level = torch.full((1, 8), 0.5)
    changed = level.clone()
    changed[0, 3] = 0.9
    steps = torch.tensor([60.0])
    with torch.no_grad():
        one, two = (network(noisy, each, base, history, after, steps) for each in (level, changed))
    difference = (one - two).abs().sum(dim=-1)[0]
    assert difference[3] == difference.max()
    assert (one[0, [0, -1]] == 0).all()  # boundary poses have no residual


def test_training_explains_more_than_the_interpolant_alone(trained):
    _, out, facts = trained
    assert facts["loss_end"] < 0.6 * facts["loss_trivial"]
    assert facts["held_out_loss"] < 0.7 * facts["held_out_trivial"]  # the held-out demonstrations share the arch
    assert all(finding.passed for finding in check_motion_model(out))


class Shrinking(torch.nn.Module):
    """Knows nothing of the data but their size: of what it is given it returns the share that is signal."""

    def forward(self, noisy, level, *context):
        return signal_and_noise(level)[0][..., None] * noisy


def test_a_network_that_only_shrinks_its_noise_has_learned_nothing(pool):
    bank = bank_of(transitions_of(pool), 256, 16, np.random.default_rng(0))
    data = tensors(bank, residual_scale(bank.residual))
    noise = torch.Generator().manual_seed(0)
    nothing = float(squared_error(torch.zeros_like(data[0]), data[0]))
    assert denoising_loss(Shrinking(), data, noise) < 0.6 * nothing
    assert float(loss_from_noise(Shrinking(), data, noise)) == pytest.approx(nothing, rel=0.01)
    assert trivial_from_noise(data[0], data[0]) < nothing


def test_a_model_that_hardly_trained_is_found_although_it_shrinks_noise(trained, tmp_path):
    folder, out, _ = trained
    motion_model({"segment_pool": {"sheet": folder}}, tmp_path, replace(SMALL, step_count=50))
    record = json.loads((tmp_path / "training.json").read_text())
    assert record["loss_end"] < 0.9 * record["loss_trivial"]
    [finding] = [item for item in check_motion_model(tmp_path) if item.name == "learned_something"]
    assert finding.blocking
    assert not finding.passed
    [fine] = [item for item in check_motion_model(out) if item.name == "learned_something"]
    assert fine.passed
    assert "on held-out demonstrations" in fine.detail


@pytest.mark.parametrize(("count", "out"), [(3, []), (4, [3]), (8, [3]), (12, [3, 8])])
def test_whole_demonstrations_are_held_out_where_there_are_enough(count, out):
    rng = np.random.default_rng(0)
    used, held_out = held_apart(
        transitions_of([part for index in range(count) for part in a_demo(f"{index:04d}", rng, 3 * index)])
    )
    assert [item.demo for item in held_out] == [f"{index:04d}" for index in out for _ in range(2)]
    assert {item.demo for item in used} == {f"{index:04d}" for index in range(count) if index not in out}


def test_samples_rise_like_the_demonstrations_where_minimum_jerk_does_not(trained):
    folder, out, _ = trained
    model = read_model(out)
    item = transitions_of(read_pool(folder))[0]
    straight = interpolate(item.history[-ENDS:], item.after, np.linspace(0, 1, len(item.path)), len(item.path) - 1)
    straight_error = np.abs(straight.position_m - item.path.position_m).max()
    errors = []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        made = transition(model, item.history, item.after, len(item.path) - 1, rng)
        errors.append(np.abs(made.position_m - item.path.position_m).max())
    assert np.median(errors) < 0.6 * straight_error
    assert jerk(made) < 5 * jerk(item.path)


def test_sampling_is_the_same_for_a_seed_and_differs_between_seeds(trained):
    folder, out, _ = trained
    model, item = read_model(out), transitions_of(read_pool(folder))[0]
    draw = [
        transition(model, item.history, item.after, 40, np.random.default_rng(seed)).position_m for seed in (3, 3, 4)
    ]
    np.testing.assert_array_equal(draw[0], draw[1])
    assert np.abs(draw[0] - draw[2]).max() > 1e-5


def test_training_twice_gives_the_same_files(trained, tmp_path):
    folder, out, _ = trained
    motion_model({"segment_pool": {"sheet": folder}}, tmp_path, SMALL)
    for name in ("model.safetensors", "model.json", "training.json"):
        assert (tmp_path / name).read_bytes() == (out / name).read_bytes()


def test_boundary_poses_of_a_sample_are_exactly_the_given_ones(trained):
    folder, out, _ = trained
    model, rng = read_model(out), np.random.default_rng(7)
    for item in transitions_of(read_pool(folder)):
        for steps in (len(item.path) - 1, 23):
            made = transition(model, item.history, item.after, steps, rng)
            assert len(made) == steps + 1
            for name in ("position_m", "rotation", "openness"):
                np.testing.assert_array_equal(getattr(made, name)[0], getattr(item.history, name)[-1])
                np.testing.assert_array_equal(getattr(made, name)[-1], getattr(item.after, name)[0])
    assert json.loads((out / "training.json").read_text())["boundary_error"] == 0


@pytest.mark.parametrize("method", ["minimum_jerk", "slicing"])
def test_the_baselines_need_no_training(pool, tmp_path, method):
    write_pool(tmp_path, pool)
    out = tmp_path / "out"
    out.mkdir()
    fit_model(tmp_path, "sheet", MotionModelConfig(method=method), out)
    assert read_model(out).network is None
    assert all(finding.passed for finding in check_motion_model(out))


def test_a_failed_demonstration_teaches_nothing(tmp_path):
    """With it and without it, the model is the same to the byte."""
    rng = np.random.default_rng(5)
    good = [part for index in range(4) for part in a_demo(f"{index:04d}", rng, 3 * index)]
    made = []
    for name, segments in (("with", [*good, *a_demo("0004", rng, 12, success=False)]), ("without", good)):
        for folder in (tmp_path / name, tmp_path / f"model_{name}"):
            folder.mkdir()
        write_pool(tmp_path / name, segments)
        config = MotionModelConfig(step_count=11, bank_count=32, width=16, layer_count=1)
        motion_model({"segment_pool": {"sheet": tmp_path / name}}, tmp_path / f"model_{name}", config)
        made.append((tmp_path / f"model_{name}" / "model.safetensors").read_bytes())
        assert json.loads((tmp_path / f"model_{name}" / "training.json").read_text())["transition_count"] == 8
    assert made[0] == made[1]


def test_without_a_successful_demonstration_there_is_nothing_to_learn(tmp_path):
    rng = np.random.default_rng(5)
    write_pool(
        tmp_path, [part for name in ("0000", "0001") for part in a_demo(name, rng, 3 * int(name), success=False)]
    )
    with pytest.raises(BadInput, match="success is false for all 2 demonstrations; record one that succeeds"):
        fit_model(tmp_path, "sheet", MotionModelConfig(method="minimum_jerk"), tmp_path)


def test_a_slice_is_the_moved_source_after_a_straight_bridge(pool):
    source, start = pool[0].path, pool[2].path[-1:]
    motion = planar(np.array([0.03, 0.01]), 0.2, np.zeros(3))
    made = sliced(source, motion, start, bridge_steps=5)
    np.testing.assert_allclose(made.position_m[6:], source.moved(motion).position_m[1:])
    np.testing.assert_allclose(np.diff(made.position_m[:6], 2, axis=0), 0, atol=1e-12)


def test_a_model_of_another_schema_is_refused(trained, tmp_path):
    _, out, _ = trained
    (tmp_path / "model.safetensors").write_bytes((out / "model.safetensors").read_bytes())
    (tmp_path / "model.json").write_text((out / "model.json").read_text().replace("motion-model/3", "motion-model/9"))
    with pytest.raises(BadInput, match="motion-model/9"):
        read_model(tmp_path)


def test_scales_have_a_floor_where_nothing_varies(pool):
    bank = bank_of(transitions_of(pool), 16, 16, np.random.default_rng(0))
    assert (residual_scale(bank.residual) > 0).all()


def test_scales_are_small_where_residuals_are(pool):
    bank = bank_of(transitions_of(pool), 64, 32, np.random.default_rng(0))
    scale = residual_scale(bank.residual)
    assert scale.shape == (32, TOKEN_SIZE)
    assert scale[1].max() < 0.5 * scale[16].max()  # beside an end, and midway
    near, midway = (np.std(bank.residual[:, token] / scale[token]) for token in (2, 16))
    assert 0.2 < near / midway < 5.0
