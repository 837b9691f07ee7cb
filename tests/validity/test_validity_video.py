import numpy as np
import pytest
import torch

from sim1.stage import BadInput
from sim1.validity.clips import Clip, read_clip, sampled, write_clip
from sim1.validity.discriminator import VideoDiscriminator, positions
from sim1.validity.scoring import (
    LabelledClip,
    held_out_figures,
    padded,
    scores,
    split_by_source,
    threshold_for,
    train_discriminator,
)


def clips(count: int, length: int = 5, size: int = 32) -> list[LabelledClip]:
    """Successes end bright, failures end dark."""
    rng = np.random.default_rng(0)
    result = []
    for index in range(count):
        success = index % 2 == 0
        frames = rng.integers(90, 110, (length, size, size, 3)).astype(np.uint8)
        frames[length // 2 :, 8:24, 8:24] = 230 if success else 20
        sources = frozenset({f"{index // 2 % 3:04d}"})
        result.append(LabelledClip(name=f"c{index}", frames=frames, success=success, sources=sources))
    return result


def test_padding_has_no_influence():
    torch.manual_seed(0)
    network = VideoDiscriminator(32, 1).eval()
    short = np.random.default_rng(0).integers(0, 255, (3, 32, 32, 3)).astype(np.uint8)
    long = np.random.default_rng(1).integers(0, 255, (7, 32, 32, 3)).astype(np.uint8)
    video, valid = padded([short, long])
    with torch.no_grad():
        together = network(video, valid)[0]
        video[0, 3:] = 0.77  # whatever stands in the padding
        garbage = network(video, valid)[0]
        alone = network(*padded([short]))[0]
    torch.testing.assert_close(together, garbage)
    torch.testing.assert_close(together, alone, atol=1e-5, rtol=1e-4)


def test_the_order_of_frames_matters():
    torch.manual_seed(0)
    network = VideoDiscriminator(32, 1).eval()
    frames = np.random.default_rng(0).integers(0, 255, (5, 32, 32, 3)).astype(np.uint8)
    forth, back = scores(network, [frames, frames[::-1]])
    assert forth != pytest.approx(back, abs=1e-6)


def test_every_position_has_its_own_code():
    table = positions(50, 32)
    distance = torch.cdist(table, table) + 10 * torch.eye(50)
    assert distance.min() > 0.1


def test_training_tells_bright_endings_from_dark_ones_and_repeats_to_the_bit():
    data = clips(8)
    settings = {"width": 16, "layer_count": 1, "step_count": 12, "batch_size": 4, "learning_rate": 1e-3}
    network, losses = train_discriminator(data, **settings, rng=np.random.default_rng(0))
    again, _ = train_discriminator(data, **settings, rng=np.random.default_rng(0))
    found = scores(network, [clip.frames for clip in data])
    success = np.array([clip.success for clip in data])
    assert found[success].min() > found[~success].max()
    assert np.mean(losses[-3:]) < 0.7 * np.mean(losses[:3])
    np.testing.assert_array_equal(found, scores(again, [clip.frames for clip in data]))


def test_no_clip_of_the_held_out_demonstration_is_trained_on():
    train, test, source = split_by_source(clips(12))
    assert source is not None
    assert test
    assert all(source in clip.sources for clip in test)
    assert not any(source in clip.sources for clip in train)
    assert len(train) + len(test) == 12


def test_nothing_is_held_out_where_one_side_would_lack_an_outcome():
    data = [clip for clip in clips(12) if clip.success or "0000" in clip.sources]  # all failures from one source
    train, test, source = split_by_source(data)
    assert (len(train), test, source) == (len(data), [], None)


def test_the_threshold_has_the_wanted_precision_at_the_most_recall():
    score = np.array([0.1, 0.2, 0.4, 0.5, 0.6, 0.8, 0.9])
    success = np.array([False, True, False, True, False, True, True])
    exact = threshold_for(score, success, 1.0)
    assert (exact.threshold, exact.precision, exact.recall) == (pytest.approx(0.7), 1.0, 0.5)
    loose = threshold_for(score, success, 0.6)
    assert loose.threshold == pytest.approx(0.15)
    assert loose.recall == 1.0


def test_no_threshold_is_better_than_an_unsupported_one():
    assert threshold_for(np.array([0.9, 0.1]), np.array([False, True]), 0.9) is None


def test_figures_carry_counts_and_wilson_intervals():
    score, success = np.array([0.1, 0.9, 0.8]), np.array([False, True, True])
    figures = held_out_figures(score, success, threshold_for(score, success, 1.0))
    assert figures["roc_area"] == 1.0
    assert (figures["success_count"], figures["failure_count"]) == (2, 1)
    assert figures["precision_ci95"][0] == pytest.approx(0.342, abs=0.001)


def test_a_clip_reads_back_and_damage_is_refused(tmp_path):
    frames = np.random.default_rng(0).integers(0, 255, (4, 6, 8, 3)).astype(np.uint8)
    write_clip(tmp_path, Clip(frames=frames, rate_hz=10.0))
    np.testing.assert_array_equal(read_clip(tmp_path).frames, frames)
    (tmp_path / "video.npz").write_bytes(b"PK")
    with pytest.raises(BadInput, match=r"video\.npz"):
        read_clip(tmp_path)


def test_picked_frames_keep_first_and_last():
    frames = np.arange(23, dtype=np.uint8)[:, None, None, None] * np.ones((1, 2, 2, 3), np.uint8)
    picked = sampled(Clip(frames=frames, rate_hz=10.0), 8)
    assert (len(picked), picked[0, 0, 0, 0], picked[-1, 0, 0, 0]) == (8, 0, 22)
