import numpy as np
import pandas as pd
import pytest
from validity_synthetic import SHEET, folding

from sim1.cloth.garment import face_areas, unique_edges
from sim1.motion.placement import planar
from sim1.stage import BadInput
from sim1.validity.features import Reference, covered_area_m2, episode_features
from sim1.validity.rules import Condition, Rules, admissible, learn_rules, read_rules, write_rules

EDGES = unique_edges(SHEET.faces)
REFERENCE = Reference(
    faces=SHEET.faces,
    edges=EDGES,
    rest_length_m=np.linalg.norm(SHEET.rest_m[EDGES[:, 0]] - SHEET.rest_m[EDGES[:, 1]], axis=-1),
    rest_area_m2=float(face_areas(SHEET.rest_m, SHEET.faces).sum()),
    start_m=SHEET.rest_m,
    keypoints={"near": 0, "far": len(SHEET.rest_m) - 1},
)
LEARNING = {"depth": 3, "recall_floor": 0.9, "margin": 0.5, "minimum_per_class": 8}


def test_a_flat_sheet_covers_its_own_area_and_a_fold_half_of_it():
    area = covered_area_m2(SHEET.rest_m, SHEET.faces)
    assert area == pytest.approx(0.30 * 0.24, rel=0.03)
    folded = folding(1.0, np.random.default_rng(0))[-1]
    assert covered_area_m2(folded, SHEET.faces) == pytest.approx(0.5 * area, rel=0.15)


def test_a_rigid_sheet_at_rest_has_no_stretch_and_no_speed():
    figures = episode_features(np.repeat(SHEET.rest_m[None], 20, axis=0), REFERENCE)
    assert figures["end.stretch_p99"] == pytest.approx(1.0)
    assert figures["end.speed_m_s"] == 0
    assert figures["end.distance_share.far-near"] == pytest.approx(1.0)
    assert figures["early.extent_long_m"] == pytest.approx(0.30, abs=1e-6)


def test_stretch_is_the_ratio_to_rest_length():
    figures = episode_features(np.repeat(1.2 * SHEET.rest_m[None], 20, axis=0), REFERENCE)
    assert figures["middle.stretch_p50"] == pytest.approx(1.2)


def test_features_do_not_depend_on_where_the_garment_lay():
    motion = folding(0.7, np.random.default_rng(0))
    place = planar(np.array([0.05, -0.02]), 0.26, np.zeros(3))
    moved = motion @ place[:3, :3].T + place[:3, 3]
    one, two = episode_features(motion, REFERENCE), episode_features(moved, REFERENCE)
    for name, value in one.items():
        assert two[name] == pytest.approx(value, abs=0.02), name


def test_end_speed_is_that_of_the_last_frames():
    still = np.repeat(SHEET.rest_m[None], 20, axis=0)
    drifting = still + np.linspace(0, 0.19, 20)[:, None, None] * np.array([0, 0, 1.0])
    assert episode_features(drifting, REFERENCE)["end.speed_m_s"] == pytest.approx(0.3, rel=1e-3)


def examples(good: int, bad: int, seed: int = 0) -> tuple[pd.DataFrame, np.ndarray]:
    """Successes have low height; the other column means nothing."""
    rng = np.random.default_rng(seed)
    success = np.arange(good + bad) < good
    height = np.where(success, rng.uniform(0.01, 0.03, good + bad), rng.uniform(0.05, 0.1, good + bad))
    return pd.DataFrame({"end.height_p99_m": height, "end.noise": rng.normal(size=good + bad)}), success


def test_a_tree_finds_the_figure_that_separates_and_keeps_the_recall_floor():
    features, success = examples(20, 20)
    rules = learn_rules(features, success, **LEARNING)
    assert rules.method == "tree"
    kept = admissible(rules, features)
    assert kept[success].mean() >= 0.9
    assert not kept[~success].any()
    assert {condition.feature for alternative in rules.any_of for condition in alternative} == {"end.height_p99_m"}


def test_the_recall_floor_holds_even_where_nothing_separates():
    rng = np.random.default_rng(1)
    features = pd.DataFrame({"a": rng.normal(size=60), "b": rng.normal(size=60)})
    success = rng.uniform(size=60) < 0.5
    rules = learn_rules(features, success, **{**LEARNING, "recall_floor": 0.95})
    assert admissible(rules, features)[success].mean() >= 0.95


def test_with_few_failures_the_range_of_the_successes_decides_and_says_so():
    features, success = examples(4, 1)
    rules = learn_rules(features, success, **LEARNING)
    assert rules.method == "intervals"
    assert "4 successes and 1 failures" in rules.reason
    assert admissible(rules, features)[success].all()


def test_intervals_reject_what_lies_far_outside():
    features, success = examples(5, 0)
    rules = learn_rules(features, success, **LEARNING)
    assert rules.broken({"end.height_p99_m": 0.5, "end.noise": 0.0})[0].endswith("is 0.5")


def test_a_limit_below_zero_is_no_limit():
    features = pd.DataFrame({"end.speed_m_s": [0.001, 0.002]})
    rules = learn_rules(features, np.ones(2, bool), **LEARNING)
    assert rules.any_of[0][0].above is None
    assert rules.any_of[0][0].below > 0.002


def test_without_a_success_nothing_can_be_learned():
    features, _ = examples(3, 3)
    with pytest.raises(ValueError, match="no successful"):
        learn_rules(features, np.zeros(6, bool), **LEARNING)


def test_written_rules_decide_like_the_learned_ones(tmp_path):
    for counts in ((20, 20), (4, 1)):
        features, success = examples(*counts)
        rules = learn_rules(features, success, **LEARNING)
        write_rules(tmp_path / "rules.yaml", rules)
        back = read_rules(tmp_path / "rules.yaml")
        np.testing.assert_array_equal(admissible(back, features), admissible(rules, features))


def test_a_value_that_is_not_a_number_is_never_admissible():
    rules = Rules(method="intervals", reason="", any_of=((Condition(feature="a", above=0.0),),))
    assert rules.broken({"a": float("nan")})
    assert rules.broken({})
    assert not rules.broken({"a": 1.0})


@pytest.mark.parametrize(
    "damage", ["", "schema: sim1.rules/9\n", "schema: sim1.rules/1\nany_of: [{all_of: [{colour: 1}]}]\n"]
)
def test_damaged_rules_are_refused_with_their_file(tmp_path, damage):
    path = tmp_path / "rules.yaml"
    path.write_text(damage)
    with pytest.raises(BadInput, match=r"rules\.yaml"):
        read_rules(path)
