"""What a proof asks, and in which order."""

from collections import Counter

import pytest

from sim1.proof.draw import TWINS, composition, draw_cases, read_cases
from sim1.stage import BadInput

TABLE = [f"effect_{number}" for number in range(17)] + ["clock_offset", "actuator_lag", "air_drag", "wind"]
OUTSIDE = [f"strange_{number}" for number in range(10)]


def drawn(count, seed=5):
    return draw_cases(count, seed, table=TABLE, outside=OUTSIDE)


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
