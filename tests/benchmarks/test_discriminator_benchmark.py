"""The benchmark of the video discriminator, on clips by formula."""

import json

import numpy as np
import pandas as pd
import pytest

from benchmarks.discriminator import turns as benchmark
from benchmarks.discriminator.episodes import judged
from benchmarks.discriminator.figures import accepted_by_class, figures_of
from benchmarks.discriminator.turns import among, pooled, run_turn, turn_by_garment, turns_by_fold
from pipeline.home import REPOSITORY
from sim1.robot.expert_task import Limits
from sim1.stage import BadInput
from sim1.validity.parts import LabelledClip
from sim1.validity.stage import StateRulesConfig, VideoDiscriminatorConfig
from sim1.validity.success import fold_excess

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


@pytest.mark.slow
def test_what_is_easily_told_apart_is_told_apart_on_demonstrations_and_garments_not_seen():
    both = {name: clips(name) for name in ("towel", "shorts")}
    turns, _ = turns_by_fold("towel", both["towel"], 4)
    for tested in ([run_turn(turn, CONFIG) for turn in turns], [run_turn(turn_by_garment("shorts", both), CONFIG)]):
        found = figures_of(pooled(tested))
        assert (found["rules"], found["both"]) == (None, None)  # no features were given to learn rules from
        assert (found["success_count"], found["failure_count"]) == (16, 16)
        assert found["roc_area"] == [1.0] * len(tested)
        assert found["precise"]["precision"]["count"] == found["precise"]["precision"]["of"]
        assert found["generous"]["recall"]["count"] >= 8


@pytest.mark.slow
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


FOLDED = {"iou": 0.9, "keypoint_error_m": 0.03, "area_ratio": 0.5, "ideal_area_ratio": 0.5, "height_m": 0.02, "speed_m_s": 0.0, "face_down_share": 0.5}  # fmt: skip


@pytest.mark.parametrize(
    ("changed", "excess"),
    [
        ({}, -0.1 / 0.8),  # the silhouette is nearest to its limit
        ({"iou": 0.8}, 0.0),  # on the line is folded
        ({"iou": 0.6}, 0.25),
        ({"keypoint_error_m": 0.09}, 0.5),
        ({"area_ratio": 0.75}, 0.25),  # 0.1 above the ideal one are allowed
        ({"height_m": np.nan}, np.nan),  # which is not up to 0: no fold
    ],
)
def test_how_far_a_fold_is_beyond_the_judges_line_is_told_as_a_share_of_the_worst_figures_limit(changed, excess):
    limits = Limits(iou=0.8, keypoint_error_m=0.06, area_excess=0.1, height_m=0.06)
    assert fold_excess(FOLDED | changed, limits) == pytest.approx(excess, nan_ok=True)


def test_what_the_judge_said_of_a_clip_is_read_by_its_name_and_told_class_by_class(tmp_path):
    rows = {
        "demos/episodes/0000": (None, FOLDED),
        "candidates/episodes/0000": ("slip", FOLDED | {"iou": 0.0}),
        "candidates/episodes/0001": ("not folded", FOLDED | {"iou": 0.72}),
        "candidates/episodes/0002": ("simulation broke", {}),  # there is no clip of it
    }
    for folder, (failure, figures) in rows.items():
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "episode.json").write_text(json.dumps({"failure": failure, "figures": figures}))
    (tmp_path / "demos" / "task.json").write_text((REPOSITORY / "data" / "tasks" / "towel.yaml").read_text())
    verdicts = judged(tmp_path / "demos", tmp_path / "candidates")
    assert verdicts == {
        "demo/0000": (None, pytest.approx(-0.1 / 0.8)),
        "candidate/0000": ("slip", pytest.approx(1.0)),
        "candidate/0001": ("not folded", pytest.approx(0.1)),
    }

    names = np.array(list(verdicts))
    accepted = np.array([True, False, True])
    tested = benchmark.Tested(
        name=names,
        success=names == "demo/0000",
        family=names,
        precise=accepted,
        generous=accepted,
        rules=names != "candidate/0001",
        roc_area=(0.9,),
    )
    assert accepted_by_class(tested, verdicts) == {
        "folded": (1, 1),
        "not folded": (1, 1),
        "slip": (0, 1),
    }
    clear = among(tested, {"demo/0000", "candidate/0000"})
    assert figures_of(clear)["generous"]["precision"]["of"] == 1
    assert figures_of(clear)["failure_count"] == 1
    rules = figures_of(tested)["rules"]["precision"]
    assert (rules["count"], rules["of"]) == (1, 2)
    assert figures_of(tested)["both"]["precision"]["of"] == 1


def test_rules_are_learned_from_all_clips_but_those_that_test():
    some = clips("towel")
    area = {clip.name: {"end.covered_share": 0.4 if clip.success else 0.9, "end.odd": 0.0} for clip in some}
    turns, _ = turns_by_fold("towel", some, 4)
    learned = pd.DataFrame.from_dict(area, orient="index")
    for turn in turns:
        admitted = benchmark.admitted(turn, learned, StateRulesConfig())
        assert admitted.tolist() == [clip.success for clip in turn.test]
        lie = learned.copy()  # what tests is turned round: rules that had seen it would follow
        lie.loc[[clip.name for clip in turn.test], "end.covered_share"] = [
            0.9 if clip.success else 0.4 for clip in turn.test
        ]
        assert benchmark.admitted(turn, lie, StateRulesConfig()).tolist() == [not clip.success for clip in turn.test]


def test_no_rule_is_learned_from_clips_that_left_the_picture():
    some = clips("towel", 64)
    turn = turns_by_fold("towel", some, 4)[0][0]
    failures = [clip.name for clip in (*turn.train, *turn.calibration) if not clip.success]
    hidden = set(failures[::4])  # folded well, and called failures as nobody saw it
    share = {clip.name: 0.5 if clip.success else 0.4 if clip.name in hidden else 0.9 for clip in some}
    share |= {clip.name: 0.4 for clip in turn.test if clip.success}
    features = pd.DataFrame({"end.covered_share": share})
    folded = [clip.success for clip in turn.test]
    assert benchmark.admitted(turn, features, StateRulesConfig(), hidden).tolist() == folded
    assert not benchmark.admitted(turn, features, StateRulesConfig()).any()  # what folds best would be a failure
