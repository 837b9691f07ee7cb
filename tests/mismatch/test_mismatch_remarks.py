"""What a verdict says besides."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from sim1.cloth.effects.coefficient import Coefficient
from sim1.mismatch.by_others import ByOthers
from sim1.mismatch.decide import Decision
from sim1.mismatch.foretold import Foretold
from sim1.mismatch.judging import Judgement
from sim1.mismatch.remarks import by_others, not_foretold, off_priors, vote
from sim1.mismatch.unfitted import NOTHING


def said(verdict, *terms):
    return Decision(verdict=verdict, null=None, chosen=SimpleNamespace(terms=terms), rivals=(), misfit={})


def judged(by_fits, decision, *asked):
    """A judgement for which motion held out was asked about models, each by its effects."""
    residuals = {terms: {"swing_b": np.zeros(1)} for terms in ((), *asked)} if asked else {}
    return Judgement(decision=decision, by_fits=by_fits, heard=replace(NOTHING, residuals=residuals), hopeful=())


def test_motion_held_out_that_nothing_was_put_to_is_told_to_have_had_no_vote():
    told = vote(("swing_b",), judged(said("none"), said("none")))
    assert told == "swing_b, which no fit saw, had no vote: the error there is of a model that was chosen without it"


def test_motion_held_out_that_was_asked_and_changed_nothing_is_told_to_have_had_a_vote():
    named = said("named", "wind")
    told = vote(("swing_b",), judged(named, named, ("wind",), ("added_mass", "wind")))
    assert "had a vote on added_mass and wind and changed nothing" in told
    assert told.endswith("the error there is of a model that it could have changed")


@pytest.mark.parametrize(
    ("by_fits", "decision", "decided"),
    [
        (said("named", "wind"), said("named", "adhesion", "wind"), "decided for adhesion"),
        (said("named", "added_mass", "wind"), said("unknown"), "decided against added_mass and wind"),
        (said("named", "wind"), said("named", "adhesion"), "decided for adhesion, against wind"),
        (said("none"), said("unknown"), "decided for unknown in place of none"),
    ],
)
def test_an_error_held_out_is_told_to_be_of_a_model_that_this_motion_helped_to_choose(by_fits, decision, decided):
    told = vote(("swing_b",), judged(by_fits, decision, ("wind",)))
    assert f"swing_b, which no fit saw, had a vote and {decided}: " in told
    assert told.endswith("the error there is of a model that it helped to choose")


@pytest.mark.parametrize(
    ("said_of_it", "told"),
    [
        ({"against": -308.4, "speaks": True}, "is 308 nats likelier with it than without, which is enough"),
        ({"against": 67.0, "speaks": False}, "is 67 nats less likely with it than without, which is not enough"),
        (
            {"against": None, "speaks": False, "unasked": "time was over"},
            "could not be foretold by what the others teach: time was over",
        ),
    ],
)
def test_what_a_recording_says_that_was_left_out_is_told_or_why_it_was_not_asked(said_of_it, told):
    named = said("named", "air_drag")
    asked = replace(judged(named, named), by_others=ByOthers(terms=("air_drag",), recording="swing_b", **said_of_it))
    [line] = by_others(asked)
    assert line.startswith("motion held out says too little for air_drag")
    assert "swing_b" in line
    assert told in line
    assert list(by_others(judged(named, named))) == []


def test_a_recording_that_no_simulation_follows_is_told_once_where_nothing_was_chosen():
    baseline = Foretold(markers_m={}, lost={"snap": "stopped at 1.2 s"})
    other = Foretold(markers_m={}, lost={"snap": "stopped at 1.3 s"})
    assert len(list(not_foretold({"baseline": baseline, "augmented": baseline}))) == 1
    told = list(not_foretold({"baseline": baseline, "augmented": other}))
    assert [line.split(" from ")[0] for line in told] == [
        "snap cannot be foretold with the calibrated baseline",
        "snap cannot be foretold with the model",
    ]


@pytest.mark.parametrize(("friction", "told"), [(0.6, 0), (0.77, 1)])
def test_a_fabric_that_is_far_from_what_was_stated_of_it_is_told(friction, told):
    """Cloth that clings to the table slides as if its friction were higher."""
    stated = Coefficient(name="friction", unit="1", scale=0.12, centre=0.272, low=0.0)
    free = Coefficient(name="length_u", unit="1", scale=1e-3, kind="log", centre=1.0)
    fit = SimpleNamespace(
        unknowns=SimpleNamespace(nominal=(stated, free)), nominal_z=np.array([stated.z(friction), free.z(1.01)])
    )
    lines = list(off_priors(fit))
    assert len(lines) == told
    assert all(
        "friction comes out as 0.77, where the bundle states 0.272: 4.2 of its stated spreads" in line for line in lines
    )
