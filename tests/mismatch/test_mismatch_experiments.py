"""What a report says to record next."""

from types import SimpleNamespace

import pytest

from sim1.cloth.effects import EFFECTS
from sim1.mismatch.experiments import SEPARATING, TESTING, next_experiment


def found(verdict, *terms, rivals=(), misfit=1.0, stopped=False):
    return SimpleNamespace(
        verdict=verdict,
        stopped=stopped,
        chosen=SimpleNamespace(terms=terms),
        rivals=tuple(SimpleNamespace(terms=one) for one in rivals),
        misfit={"chosen": misfit},
    )


def test_a_name_that_others_can_imitate_is_given_with_the_recording_that_would_show_it():
    assert next_experiment(found("named", "gravity_tilt")).startswith("none needed; to be sure, hang a plumb line")
    assert (
        next_experiment(found("named", "air_drag"))
        == next_experiment(found("none"))
        == "none needed for this difference"
    )


@pytest.mark.parametrize("pair", SEPARATING, ids=lambda pair: " and ".join(sorted(pair)))
def test_two_names_that_are_taken_for_each_other_are_told_apart_by_a_recording(pair):
    first, second = sorted(pair)
    said = SEPARATING[pair]
    assert next_experiment(found("ambiguous", first, rivals=((second,),))) == said
    assert next_experiment(found("named", first, second)) == said


def test_what_is_left_or_unknown_asks_for_another_speed_and_a_search_that_was_stopped_for_more_time():
    assert "slower" in next_experiment(found("unknown"))
    assert "slower" in next_experiment(found("named", "air_drag", misfit=2.0))
    assert "at another speed" in next_experiment(found("ambiguous", "shrinkage", rivals=(("wind",),)))
    assert "more time" in next_experiment(found("unknown", stopped=True))


def test_every_name_that_is_given_a_recording_is_an_effect():
    assert set(TESTING) <= set(EFFECTS)
    assert set().union(*SEPARATING) <= set(EFFECTS)
