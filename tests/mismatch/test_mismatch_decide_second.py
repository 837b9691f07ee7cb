"""A second effect beside the first: what it must earn, and what takes it away."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from small_pool import pool_of, verdict

from sim1.mismatch.decide import decide, there
from sim1.mismatch.thresholds import THRESHOLDS

pytestmark = pytest.mark.usefixtures("counted_once")


def test_what_the_formula_of_a_strong_effect_leaves_is_no_second_effect(unknowns):
    """A grip that yields gains 5061 nats, and stiffening threads beside it 127 more."""
    first, pair = ("grip_compliance",), ("grip_compliance", "strain_stiffening")
    cheap = replace(THRESHOLDS, named=30.0)
    assert verdict(unknowns, {first: 5061.0, pair: 5061.0 + 127.0}, thresholds=cheap) == ("named", first)
    assert verdict(unknowns, {first: 2000.0, pair: 2000.0 + 127.0}, thresholds=cheap) == ("named", pair)


def test_a_pair_gives_way_to_one_of_its_own_or_to_the_best_of_all_that_are_single(unknowns, monkeypatch):
    pair, part, other = ("air_drag", "shrinkage"), ("air_drag",), ("clock_offset",)
    pool = pool_of(unknowns, {pair: 2300.0, part: 2000.0, other: 1500.0})
    monkeypatch.setattr(
        "sim1.mismatch.decide.overcounted",
        lambda fit, base: 13.0 if fit is pool[1].fit and base is pool[3].fit else 1.0,
    )
    assert decide(pool, THRESHOLDS).chosen.terms == pair
    assert verdict(unknowns, {pair: 480.0, part: 200.0, other: 470.0}) == ("named", other)


def test_a_pair_that_gives_way_to_a_part_that_does_not_stand_takes_no_other_name_away(unknowns, monkeypatch):
    part, pair, other = ("adhesion",), ("adhesion", "wind"), ("shrinkage",)
    gains = {part: 2.1 * THRESHOLDS.named, pair: 2.6 * THRESHOLDS.named, other: 1.6 * THRESHOLDS.named}
    pool = pool_of(unknowns, gains)
    monkeypatch.setattr(
        "sim1.mismatch.decide.overcounted",
        lambda fit, base: 5.0 if fit is pool[1].fit else 2.5 if fit is pool[2].fit and base is pool[0].fit else 1.0,
    )
    found = decide(pool, THRESHOLDS)
    assert (found.verdict, found.chosen.terms) == ("ambiguous", other)
    assert [rival.terms for rival in found.rivals] == [part]
    assert decide(pool[:3], THRESHOLDS).verdict == "none"


def test_a_second_effect_that_follows_one_error_again_and_again_is_not_named(unknowns, monkeypatch):
    pair = ("air_drag", "shrinkage")
    pool = pool_of(unknowns, {("air_drag",): 400.0, pair: 400.0 + 3.0 * THRESHOLDS.named})
    assert decide(pool, THRESHOLDS).chosen.terms == pair
    monkeypatch.setattr("sim1.mismatch.decide.overcounted", lambda fit, base: 3.1 if base is pool[1].fit else 1.0)
    assert decide(pool, THRESHOLDS).chosen.terms == ("air_drag",)


def test_a_second_effect_must_earn_its_place(unknowns):
    pair = ("air_drag", "shrinkage")
    little, much = (
        {("air_drag",): 400.0, pair: 400.0 + gain} for gain in (0.5 * THRESHOLDS.named, 1.2 * THRESHOLDS.named)
    )
    assert verdict(unknowns, little) == ("named", ("air_drag",))
    assert verdict(unknowns, much) == ("named", pair)


def test_a_second_effect_needs_little_of_what_the_first_gained(unknowns):
    """Clocks that are off by 20 ms gain thousands of nats; a tilt of 2 degrees beside them some hundreds."""
    pair, first = ("clock_offset", "gravity_tilt"), ("clock_offset",)
    share = THRESHOLDS.second_share * 6000.0
    assert verdict(unknowns, {first: 6000.0, pair: 6000.0 + 1.2 * share}) == ("named", pair)
    assert verdict(unknowns, {first: 6000.0, pair: 6000.0 + 0.8 * share}) == ("named", first)
    assert verdict(unknowns, {first: 600.0, pair: 600.0 + 0.8 * THRESHOLDS.named}) == ("named", first)


def test_wind_must_earn_what_it_adds_to_the_drag_that_it_contains(unknowns):
    assert verdict(unknowns, {("wind",): 310.0, ("air_drag",): 300.0}) == ("named", ("air_drag",))
    assert verdict(unknowns, {("wind",): 400.0, ("air_drag",): 300.0}) == ("named", ("wind",))


def test_drag_beside_another_is_named_where_a_stream_that_fits_a_little_better_shows_that_air_is_missing(unknowns):
    """Air at rest adds 31 nats to what bending does, a stream 46, and a stiff place beside it less than that."""
    alone, second = ("bending_hysteresis",), THRESHOLDS.named
    drag, wind, place = ("air_drag", *alone), (*alone, "wind"), (*alone, "stiff_region")
    gains = {alone: 500.0, drag: 500.0 + 0.9 * second, place: 500.0 + 0.95 * second}
    assert verdict(unknowns, gains) == ("named", alone)
    assert verdict(unknowns, gains | {wind: 500.0 + 1.3 * second}) == ("named", drag)
    assert verdict(unknowns, gains | {wind: 500.0 + 1.05 * second}) == ("ambiguous", drag)
    assert verdict(unknowns, gains | {wind: 500.0 + 2.3 * second}) == ("named", wind)


def test_a_second_effect_that_the_first_imitates_by_leaving_its_priors_is_there_whatever_recordings_say(
    unknowns, monkeypatch
):
    """Lengths beside an offset of the frame are bent to those of cloth that has shrunk."""
    monkeypatch.setattr("sim1.mismatch.decide.established_along", lambda fit, base, level: False)
    two = tuple(SimpleNamespace(effect=SimpleNamespace(name=name)) for name in ("frame_offset", "shrinkage"))
    null, first, pair = pool_of(unknowns, {("frame_offset",): 800.0, ("frame_offset", "shrinkage"): 805.0})
    none = {"only": np.zeros((10, 1))}
    pair = replace(pair, fit=replace(pair.fit, unknowns=SimpleNamespace(terms=two[1:]), z=np.zeros(1), slopes=none))
    for nats, said in ((0.9 * THRESHOLDS.named, False), (1.2 * THRESHOLDS.named, True)):
        bent = replace(first, fit=replace(first.fit, z=np.array([np.sqrt(2.0 * nats)]), slopes=none))
        assert there([null, bent, pair], pair, THRESHOLDS) == said
