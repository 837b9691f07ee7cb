import json

import numpy as np
import pytest
import torch
from motion_synthetic import a_demo

from sim1.motion.fitting import fit_model, jerk
from sim1.motion.interpolant import interpolate
from sim1.motion.model import read_model, sliced, transition
from sim1.motion.network import MotionTransformer, signal_and_noise
from sim1.motion.placement import planar
from sim1.motion.pool import read_pool, write_pool
from sim1.motion.poses import joined
from sim1.motion.stage import MotionModelConfig, check_motion_model, motion_model
from sim1.motion.transitions import HISTORY_COUNT, augmented, bank_of, moving_frames, residual_scale, transitions_of
from sim1.stage import BadInput

SMALL = MotionModelConfig(step_count=120, bank_count=128, width=32, layer_count=2)


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pool")
    rng = np.random.default_rng(5)
    write_pool(folder, [part for index in range(4) for part in a_demo(f"{index:04d}", rng, 3 * index)])
    out = tmp_path_factory.mktemp("model")
    facts = motion_model({"segment_pool": {"sheet": folder}}, out, SMALL)
    return folder, out, facts


def test_a_pool_reads_back_as_it_was_written(pool, tmp_path):
    write_pool(tmp_path, pool)
    back = read_pool(tmp_path)
    assert [part.segment for part in back] == [part.segment for part in pool]
    np.testing.assert_array_equal(back[1].path.position_m, pool[1].path.position_m)
    assert back[1].grasps == [0, 1]


def test_a_damaged_pool_is_refused_with_its_file(pool, tmp_path):
    write_pool(tmp_path, pool)
    (tmp_path / "segments.npz").write_bytes(b"no longer a zip")
    with pytest.raises(BadInput, match=str(tmp_path)):
        read_pool(tmp_path)


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
    assert 9 <= start <= 13
    assert len(waiting) - 25 <= end <= len(waiting) - 20


def test_augmented_transitions_keep_their_speed_and_history(pool):
    original = transitions_of(pool)[1]
    rng = np.random.default_rng(0)
    speeds = np.linalg.norm(np.diff(original.path.position_m, axis=0), axis=-1)
    for _ in range(20):
        varied = augmented(original, rng)
        varied_speeds = np.linalg.norm(np.diff(varied.path.position_m, axis=0), axis=-1)
        assert varied_speeds.max() <= speeds.max() + 1e-12
        np.testing.assert_allclose(varied.history.position_m[-1], varied.path.position_m[0])


def test_the_schedule_preserves_variance_and_ends_clean():
    signal, noise = signal_and_noise(torch.linspace(0, 1, 11))
    torch.testing.assert_close(signal**2 + noise**2, torch.ones(11))
    assert float(noise[0]) == 0
    assert float(signal[-1]) == pytest.approx(0, abs=1e-6)


def test_a_token_hears_of_its_own_noise_level():
    torch.manual_seed(0)
    network = MotionTransformer(32, 1, 8)
    torch.nn.init.normal_(network.out.weight)
    noisy, base, history = torch.randn(1, 8, 20), torch.randn(1, 8, 20), torch.randn(1, HISTORY_COUNT, 20)
    level = torch.full((1, 8), 0.5)
    changed = level.clone()
    changed[0, 3] = 0.9
    steps = torch.tensor([60.0])
    with torch.no_grad():
        one, two = (network(noisy, each, base, history, steps) for each in (level, changed))
    difference = (one - two).abs().sum(dim=-1)[0]
    assert difference[3] == difference.max()
    assert (one[0, [0, -1]] == 0).all()  # boundary poses have no residual


def test_training_explains_more_than_the_interpolant_alone(trained):
    _, out, facts = trained
    assert facts["loss_end"] < 0.6 * facts["loss_trivial"]
    assert facts["held_out_loss"] < 0.7 * facts["held_out_trivial"]  # the held-out demonstrations share the arch
    assert all(finding.passed for finding in check_motion_model(out))


def test_samples_rise_like_the_demonstrations_where_minimum_jerk_does_not(trained):
    folder, out, _ = trained
    model = read_model(out)
    item = transitions_of(read_pool(folder))[0]
    velocity = np.zeros((2, 3))
    straight_error = np.abs(_straight(item, velocity).position_m - item.path.position_m).max()
    errors = []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        made = transition(model, item.history, item.path[-1:], velocity, len(item.path) - 1, rng)
        errors.append(np.abs(made.position_m - item.path.position_m).max())
    assert np.median(errors) < 0.6 * straight_error
    assert jerk(made) < 5 * jerk(item.path)


def _straight(item, velocity):
    return interpolate(item.path[:1], item.path[-1:], np.linspace(0, 1, len(item.path)), velocity, velocity)


def test_sampling_is_the_same_for_a_seed_and_differs_between_seeds(trained):
    folder, out, _ = trained
    model, item = read_model(out), transitions_of(read_pool(folder))[0]
    draw = [
        transition(model, item.history, item.path[-1:], np.zeros((2, 3)), 40, np.random.default_rng(seed)).position_m
        for seed in (3, 3, 4)
    ]
    np.testing.assert_array_equal(draw[0], draw[1])
    assert np.abs(draw[0] - draw[2]).max() > 1e-5


def test_training_twice_gives_the_same_files(trained, tmp_path):
    folder, out, _ = trained
    motion_model({"segment_pool": {"sheet": folder}}, tmp_path, SMALL)
    for name in ("model.safetensors", "model.json", "training.json"):
        assert (tmp_path / name).read_bytes() == (out / name).read_bytes()


def test_boundary_poses_of_a_sample_are_exactly_the_given_ones(trained):
    _, out, _ = trained
    assert json.loads((out / "training.json").read_text())["boundary_error"] == 0


@pytest.mark.parametrize("method", ["minimum_jerk", "slicing"])
def test_the_baselines_need_no_training(pool, tmp_path, method):
    write_pool(tmp_path, pool)
    out = tmp_path / "out"
    out.mkdir()
    fit_model(tmp_path, "sheet", MotionModelConfig(method=method), out)
    assert read_model(out).network is None
    assert all(finding.passed for finding in check_motion_model(out))


def test_a_slice_is_the_moved_source_after_a_straight_bridge(pool):
    source, start = pool[0].path, pool[2].path[-1:]
    motion = planar(np.array([0.03, 0.01]), 0.2, np.zeros(3))
    made = sliced(source, motion, start, bridge_steps=5)
    np.testing.assert_allclose(made.position_m[6:], source.moved(motion).position_m[1:])
    np.testing.assert_allclose(np.diff(made.position_m[:6], 2, axis=0), 0, atol=1e-12)


def test_a_model_of_another_schema_is_refused(trained, tmp_path):
    _, out, _ = trained
    (tmp_path / "model.safetensors").write_bytes((out / "model.safetensors").read_bytes())
    (tmp_path / "model.json").write_text((out / "model.json").read_text().replace("motion-model/1", "motion-model/9"))
    with pytest.raises(BadInput, match="motion-model/9"):
        read_model(tmp_path)


def test_scales_have_a_floor_where_nothing_varies(pool):
    bank = bank_of(transitions_of(pool), 16, 16, np.random.default_rng(0))
    assert (residual_scale(bank.residual) > 0).all()
