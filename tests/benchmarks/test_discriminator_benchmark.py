"""The benchmark of the video discriminator, on clips by formula."""

import numpy as np
import pytest

from benchmarks.discriminator import figures_of, pooled, run_turn, turn_by_garment, turns_by_fold
from sim1.stage import BadInput
from sim1.validity.parts import LabelledClip
from sim1.validity.stage import VideoDiscriminatorConfig

CONFIG = VideoDiscriminatorConfig(width=16, layer_count=1, step_count=12, learning_rate=1e-3)


def clips(garment: str, count: int = 32, demos: int = 4) -> list[LabelledClip]:
    """Successes end bright, failures end dark; each demonstration has some of both."""
    rng, result = np.random.default_rng(0), []
    for index in range(count):
        frames = rng.integers(90, 110, (4, 32, 32, 3)).astype(np.uint8)
        frames[2:, 8:24, 8:24] = 230 if index % 2 == 0 else 20
        sources = frozenset({f"{garment}/{index // 2 % demos}"})
        result.append(LabelledClip(name=f"{garment}{index}", frames=frames, success=index % 2 == 0, sources=sources))
    return result


def test_every_clip_is_tested_once_by_a_network_that_saw_nothing_of_its_demonstration():
    turns, left_out = turns_by_fold("towel", clips("towel"), 4)
    assert left_out == 0
    assert sorted(clip.name for turn in turns for clip in turn.test) == sorted(clip.name for clip in clips("towel"))
    for turn in turns:
        train, calibration, test = (
            set().union(*(clip.sources for clip in some)) for some in (turn.train, turn.calibration, turn.test)
        )
        assert train
        assert train.isdisjoint(calibration | test)
        assert calibration.isdisjoint(test)


def test_clips_that_mix_demonstrations_of_several_folds_are_left_out_and_counted():
    mixed = LabelledClip(
        name="mixed",
        frames=np.zeros((4, 32, 32, 3), np.uint8),
        success=True,
        sources=frozenset(f"towel/{number}" for number in range(4)),
    )
    turns, left_out = turns_by_fold("towel", [*clips("towel"), mixed], 4)
    assert left_out == 1
    assert "mixed" not in {clip.name for turn in turns for clip in (*turn.train, *turn.calibration, *turn.test)}


def test_what_is_easily_told_apart_is_told_apart_on_demonstrations_and_garments_not_seen():
    both = {name: clips(name) for name in ("towel", "shorts")}
    turns, _ = turns_by_fold("towel", both["towel"], 4)
    for tested in ([run_turn(turn, CONFIG) for turn in turns], [run_turn(turn_by_garment("shorts", both), CONFIG)]):
        found = figures_of(pooled(tested))
        assert (found["success_count"], found["failure_count"]) == (16, 16)
        assert found["roc_area"] == [1.0] * len(tested)
        assert found["precise"]["precision"]["count"] == found["precise"]["precision"]["of"]
        assert found["generous"]["recall"]["count"] >= 8


def test_a_network_that_knows_nothing_is_seen_to_know_nothing():
    dark = [
        LabelledClip(name=clip.name, frames=np.zeros_like(clip.frames), success=clip.success, sources=clip.sources)
        for clip in clips("towel")
    ]
    turns, _ = turns_by_fold("towel", dark, 4)
    found = figures_of(pooled([run_turn(turn, CONFIG) for turn in turns]))
    assert found["roc_area"] == [pytest.approx(0.5)] * 4
    assert found["precise"]["precision"] == {
        "count": 0,
        "of": 0,
        "ci95": [0.0, 1.0],
    }  # no threshold reaches what is wanted
    assert found["generous"]["precision"]["of"] == 32  # alike: what keeps four in five keeps all


def test_a_fold_without_a_failure_is_told():
    turns, _ = turns_by_fold("towel", [clip for clip in clips("towel") if clip.success], 4)
    with pytest.raises(BadInput, match=r"towel, fold 0: 8 of 8 clips of the part train are successes.*fewer folds"):
        run_turn(turns[0], CONFIG)
