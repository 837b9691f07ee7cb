"""What a proof asks, and in which order."""

import json
from collections import Counter

import pytest

from benchmarks.concealed.effects.library import LIBRARY
from pipeline.home import REPOSITORY
from sim1.proof.draw import TWINS, composition, draw_cases, read_cases
from sim1.stage import BadInput

TABLE = [f"effect_{number}" for number in range(17)] + ["clock_offset", "actuator_lag", "air_drag", "wind"]
OUTSIDE = [f"strange_{number}" for number in range(10)]


def drawn(count, seed=5, strength=None):
    return draw_cases(count, seed, table=TABLE, outside=OUTSIDE, strength=strength)


def kind(case):
    if not case.effects:
        return "null"
    return "outside" if case.effects[0] in OUTSIDE else "pair" if len(case.effects) == 2 else "single"


@pytest.mark.parametrize("count", [60, 75, 100])
def test_from_sixty_cases_on_every_effect_is_there_beside_nulls_strangers_and_pairs(count):
    kinds = Counter(kind(case) for case in drawn(count))
    assert kinds == {"null": 20, "outside": 8, "pair": 8, "single": count - 36}
    singles = [case.effects[0] for case in drawn(count) if kind(case) == "single"]
    assert set(singles) == set(TABLE)
    assert max(Counter(singles).values()) - min(Counter(singles).values()) <= 1
    assert len({case.effects for case in drawn(count) if kind(case) == "outside"}) == 8


@pytest.mark.parametrize("count", range(1, 60))
def test_fewer_cases_keep_the_shares(count):
    counts = composition(count)
    assert sum(counts.values()) == count
    for name, share in (("null", 20), ("outside", 8), ("pair", 8), ("single", 24)):
        assert counts[name] == pytest.approx(share * count / 60, abs=1.5)


@pytest.mark.parametrize("seed", range(5))
def test_every_beginning_of_the_list_is_a_fair_mix(seed):
    cases = drawn(60, seed)
    for length in range(1, 61):
        kinds = Counter(kind(case) for case in cases[:length])
        for name, share in (("null", 20), ("outside", 8), ("pair", 8), ("single", 24)):
            assert abs(kinds[name] - share * length / 60) < 2.5
    assert len({case.effects for case in cases if kind(case) == "single"}) == 21
    early = [case.effects for case in cases if kind(case) == "single"][:21]
    assert len(set(early)) == 21  # none comes again before all have come


def strengths(cases, of):
    return [case.strength for case in cases if kind(case) == of]


@pytest.mark.parametrize("count", [60, 75, 100])
def test_single_effects_are_medium_or_strong_until_all_of_the_table_were_there_and_weak_beyond_that(count):
    singles = strengths(drawn(count), "single")
    assert set(singles[: len(TABLE)]) == {"medium", "strong"}
    assert singles[len(TABLE) :] == ["weak"] * (count - 36 - len(TABLE))


def test_where_fewer_are_drawn_than_the_table_has_none_is_weak():
    for count in range(1, 54):
        cases = drawn(count)
        assert len(strengths(cases, "single")) <= len(TABLE)
        assert "weak" not in {case.strength for case in cases}


def test_strangers_and_pairs_are_medium_or_strong_by_a_fair_coin_and_of_nothing_the_strength_means_nothing():
    campaigns = [drawn(60, seed) for seed in range(40)]
    for of in ("outside", "pair"):
        tossed = [strength for cases in campaigns for strength in strengths(cases, of)]
        assert set(tossed) == {"medium", "strong"}
        assert tossed.count("strong") / len(tossed) == pytest.approx(0.5, abs=0.1)
    assert {strength for cases in campaigns for strength in strengths(cases, "null")} == {"medium"}


@pytest.mark.parametrize("strength", ["weak", "medium", "strong"])
def test_a_strength_that_is_given_holds_for_all_and_changes_nothing_else(strength):
    given, free = drawn(60, strength=strength), drawn(60)
    assert {case.strength for case in given} == {strength}
    assert [(case.effects, case.seed) for case in given] == [(case.effects, case.seed) for case in free]


def test_a_stored_campaign_is_drawn_as_it_was_by_its_seed_and_strength():
    stored = json.loads((REPOSITORY / "docs" / "campaign" / "along" / "answers" / "drawn.json").read_text())
    table = [name for name, recipe in LIBRARY.items() if recipe.in_table]
    outside = [name for name, recipe in LIBRARY.items() if not recipe.in_table]
    again = draw_cases(60, int(stored["seed"]), table=table, outside=outside, strength="medium")
    assert [case.model_dump(mode="json") for case in again] == stored["cases"]


def test_the_same_seed_draws_the_same_and_another_seed_something_else():
    assert drawn(20) == drawn(20)
    assert drawn(20) != drawn(20, 6)
    assert len({case.seed for case in drawn(60)}) == 60


def test_pairs_are_two_things_that_can_be_told_apart():
    pairs = [case.effects for seed in range(40) for case in drawn(60, seed) if kind(case) == "pair"]
    assert all(one != other and frozenset((one, other)) not in TWINS for one, other in pairs)
    assert len(set(pairs)) > 100


def test_chosen_cases_are_read_and_wrong_ones_refused_by_name(tmp_path):
    path = tmp_path / "cases.yaml"
    path.write_text("- {effects: [air_drag, wind], strength: weak, seed: 3}\n- {effects: [none], seed: 4}\n")
    first, second = read_cases(path)
    assert (first.effects, first.strength, first.seed) == (("air_drag", "wind"), "weak", 3)
    assert (second.effects, second.strength) == ((), "medium")
    for text, said in (
        ("- {effects: [wind], sed: 3}", "unknown key '0.sed'"),
        ("- {effects: [wind], seed: -3}", "0.seed"),
        ("- {effects: [wind], strength: mad, seed: 3}", "0.strength"),
        ("[]", "no case"),
        ("a: [", "not readable as YAML"),
    ):
        path.write_text(text)
        with pytest.raises(BadInput, match=r"cases\.yaml") as caught:
            read_cases(path)
        assert said in str(caught.value)
