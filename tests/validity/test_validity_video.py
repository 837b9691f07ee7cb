import re
from dataclasses import replace

import numpy as np
import pytest
import torch

from sim1.stage import BadInput
from sim1.validity.clips import Clip, read_clip, sampled, write_clip
from sim1.validity.discriminator import VideoDiscriminator, positions
from sim1.validity.evidence import Outcome, doubt, figures, outcome, threshold_for
from sim1.validity.parts import LabelledClip, split_by_source
from sim1.validity.scoring import padded, scores, train_discriminator
from sim1.validity.stage import VideoDiscriminatorConfig


def clips(count: int, length: int = 5, size: int = 32, demos: int = 3) -> list[LabelledClip]:
    """Successes end bright, failures end dark."""
    rng = np.random.default_rng(0)
    result = []
    for index in range(count):
        success = index % 2 == 0
        frames = rng.integers(90, 110, (length, size, size, 3)).astype(np.uint8)
        frames[length // 2 :, 8:24, 8:24] = 230 if success else 20
        sources = frozenset({f"{index // 2 % demos:04d}"})
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


class NoAttention(torch.nn.Module):
    def forward(self, features, src_key_padding_mask):
        return features


def test_the_score_is_read_at_the_last_frame_that_is_no_padding():
    torch.manual_seed(0)
    network = VideoDiscriminator(32, 1).eval()
    network.encoder = NoAttention()  # what a frame's output is then is of that frame alone
    one, other, last = np.random.default_rng(0).integers(0, 255, (3, 32, 32, 3)).astype(np.uint8)
    clip, unlike_before, unlike_at_the_end = (
        np.stack(frames) for frames in ([one, one, last], [other, other, last], [one, one, other])
    )
    with torch.no_grad():
        video, valid = padded([clip, unlike_before, unlike_at_the_end, np.stack([one] * 5)])
        first, second, third, _ = network(video, valid)
    torch.testing.assert_close(first, second)
    assert abs(float(first - third)) > 1e-6


def test_every_position_has_its_own_code():
    table = positions(50, 32)
    distance = torch.cdist(table, table) + 10 * torch.eye(50)
    assert distance.min() > 0.1


def test_training_tells_bright_endings_from_dark_ones_and_repeats_to_the_bit():
    data = clips(8)
    config = VideoDiscriminatorConfig(width=16, layer_count=1, step_count=12, batch_size=4, learning_rate=1e-3)
    network, losses = train_discriminator(data, config, np.random.default_rng(0))
    again, _ = train_discriminator(data, config, np.random.default_rng(0))
    found = scores(network, [clip.frames for clip in data])
    success = np.array([clip.success for clip in data])
    assert found[success].min() > found[~success].max()
    assert np.mean(losses[-3:]) < 0.7 * np.mean(losses[:3])
    np.testing.assert_array_equal(found, scores(again, [clip.frames for clip in data]))


def named(clips):
    return {clip.name for clip in clips}


def sources_of(clips):
    return set().union(*(clip.sources for clip in clips))


def test_each_demonstration_trains_calibrates_or_tests_and_all_have_both_outcomes():
    data = clips(30, length=1, demos=7)
    parts = split_by_source(data)
    split = [parts.train, parts.calibration, parts.test]
    assert not parts.left_out
    assert sum(map(len, split)) == len(named(parts.train + parts.calibration + parts.test)) == 30
    assert sum(len(sources_of(part)) for part in split) == len(sources_of(data)) == 7
    assert all({clip.success for clip in part} == {True, False} for part in split)
    assert len(parts.train) > len(parts.test) > 4


@pytest.mark.parametrize("demos", [4, 5, 7])
def test_clips_of_two_demonstrations_leave_no_demonstration_in_two_parts_and_are_left_out_where_those_differ(demos):
    """Every pair of demonstrations, as the two steps of a task mix them."""
    pairs = [{f"{one:04d}", f"{two:04d}"} for one in range(demos) for two in range(demos)]
    data = [
        replace(clip, sources=frozenset(pair))
        for clip, pair in zip(clips(2 * len(pairs), length=1), [pair for pair in pairs for _ in range(2)], strict=True)
    ]
    parts = split_by_source(data)
    split = [parts.train, parts.calibration, parts.test]
    used = [sources_of(part) for part in split]
    assert all(used)
    assert sum(map(len, used)) == len(set().union(*used))
    assert named(parts.left_out) == named(data) - named([clip for part in split for clip in part])
    assert all(sum(not clip.sources.isdisjoint(part) for part in used) > 1 for clip in parts.left_out)
    assert sum(map(len, split)) + len(parts.left_out) == len(data)


def test_two_demonstrations_are_not_enough_to_calibrate_and_test_on_different_ones():
    parts = split_by_source(clips(16, length=1, demos=2))
    assert sorted([len(parts.calibration), len(parts.test)]) == [0, 8]
    assert not sources_of(parts.train) & sources_of(parts.calibration + parts.test)


def test_nothing_is_held_out_where_training_would_lack_an_outcome():
    data = [
        clip for clip in clips(12, length=1) if clip.success or "0000" in clip.sources
    ]  # all failures from one source
    parts = split_by_source(clips(12, length=1, demos=1))
    assert (len(parts.train), parts.calibration, parts.test) == (12, [], [])
    alone = split_by_source(data)
    assert {clip.success for clip in alone.train} == {True, False}
    assert {clip.success for clip in alone.calibration} != {True, False}


def test_the_threshold_has_the_wanted_precision_at_the_most_recall():
    score = np.array([0.1, 0.2, 0.4, 0.5, 0.6, 0.8, 0.9])
    success = np.array([False, True, False, True, False, True, True])
    exact = threshold_for(score, success, 1.0)
    assert exact == pytest.approx(0.7)
    assert outcome(score, success, exact).recall == 0.5
    loose = threshold_for(score, success, 0.6)
    assert loose == pytest.approx(0.15)
    assert outcome(score, success, loose).recall == 1.0


def test_no_threshold_is_better_than_an_unsupported_one():
    assert threshold_for(np.array([0.9, 0.1]), np.array([False, True]), 0.9) is None
    assert threshold_for(np.empty(0), np.empty(0, bool), 0.9) is None  # nobody could be held out


def test_figures_carry_counts_and_wilson_intervals():
    score, success = np.array([0.1, 0.9, 0.8]), np.array([False, True, True])
    found = figures(score, success, 0.5)
    assert found["roc_area"] == found["precision"] == 1.0
    assert (found["success_count"], found["failure_count"]) == (2, 1)
    assert found["precision_ci95"][0] == pytest.approx(0.342, abs=0.001)
    nothing = figures(score, success, 0.95)
    assert nothing["precision"] is None
    assert nothing["precision_ci95"] == [0.0, 1.0]


@pytest.mark.parametrize(
    ("accepted", "right", "successes", "failures", "why"),
    [
        (8, 8, 10, 10, ""),
        (2, 2, 2, 2, "too few test clips: 4, 2 of the rarer outcome"),
        (8, 5, 10, 10, "5 of 8 = 62 %.* not surely more than accepting all gives, 50%"),
        (20, 16, 20, 60, "16 of 20 = 80 %.*wanted 99%"),
        (4, 4, 12, 12, "keeps only 33% of the 12 successes"),
        (0, 0, 10, 10, "none tried, not surely more"),
    ],
)
def test_what_the_test_clips_do_not_support_is_said(accepted, right, successes, failures, why):
    found = Outcome(accepted=accepted, accepted_success=right, success_count=successes, failure_count=failures)
    said = doubt(found, wanted=0.99, least=4)
    assert re.search(why, said) if why else said == ""


def test_a_clip_reads_back_and_damage_is_refused(tmp_path):
    frames = np.random.default_rng(0).integers(0, 255, (4, 6, 8, 3)).astype(np.uint8)
    write_clip(tmp_path, Clip(frames=frames, rate_hz=10.0))
    np.testing.assert_array_equal(read_clip(tmp_path).frames, frames)
    (tmp_path / "video.npz").write_bytes(b"PK")
    with pytest.raises(BadInput, match=r"video\.npz"):
        read_clip(tmp_path)


def test_picked_frames_keep_first_and_last():
    frames = np.arange(23, dtype=np.uint8)[:, None, None, None] * np.ones((1, 2, 2, 3), np.uint8)
    picked = sampled(frames, 8)
    assert (len(picked), picked[0, 0, 0, 0], picked[-1, 0, 0, 0]) == (8, 0, 22)
