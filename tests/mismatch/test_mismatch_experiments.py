"""What a report says to record next."""

from types import SimpleNamespace

import pytest
from small_pool import fitted

from sim1.cloth.effects import EFFECTS
from sim1.mismatch.apart import apart
from sim1.mismatch.experiments import left_open, next_experiment
from sim1.mismatch.models import Model
from sim1.mismatch.separating import SEPARATING


@pytest.fixture
def model(unknowns):
    """Makes a model by its effects and the mean squares of what it leaves, by recording."""

    def make(*terms, swing_a=1.0, lift_b=1.0):
        return Model(terms=terms, fit=fitted(unknowns, swing_a=swing_a, lift_b=lift_b), variants=1)

    return make


def found(verdict, chosen, *rivals, misfit=1.0, stopped=False):
    return SimpleNamespace(verdict=verdict, stopped=stopped, chosen=chosen, rivals=rivals, misfit={"chosen": misfit})


def test_a_name_that_others_can_imitate_is_given_with_the_recording_that_would_show_it(model):
    tilted = found("named", model("gravity_tilt"))
    assert next_experiment(tilted).startswith("none needed; to be sure, hang a plumb line")
    assert "gravity_tilt" in left_open(tilted).what


def test_what_leaves_nothing_open_asks_for_nothing(model):
    for clear in (found("named", model("air_drag")), found("none", model())):
        assert left_open(clear) is None
        assert next_experiment(clear) == "none needed for this difference"


def test_two_models_are_the_farther_apart_the_more_their_simulations_differ_in_units_of_noise(unknowns):
    one, other = fitted(unknowns, swing_a=1.0, lift_b=1.0), fitted(unknowns, swing_a=1.44, lift_b=4.0)
    assert [(row.recording, row.noises) for row in apart(one, other)] == [
        ("lift_b", pytest.approx(1.0)),
        ("swing_a", pytest.approx(0.2)),
    ]


def test_of_two_that_explain_it_alike_the_recording_in_which_they_differ_most_is_to_be_repeated(model):
    asked = found("ambiguous", model("shrinkage"), model("wind", lift_b=1.44))
    said = next_experiment(asked)
    assert said.startswith(
        "repeat lift_b, in which shrinkage and wind differ most (0.2 times noise and mesh error; 0 in swing_a)"
    )
    assert EFFECTS["shrinkage"].varied in said
    assert EFFECTS["wind"].varied in said
    assert left_open(asked).what == "whether it is shrinkage or wind"


def test_among_rivals_the_closest_is_to_be_told_apart(model):
    far, near = model("wind", swing_a=4.0), model("air_drag", lift_b=1.1)
    assert left_open(found("ambiguous", model("shrinkage"), far, near)).what == "whether it is shrinkage or air_drag"


def test_what_both_have_is_not_varied(model):
    said = next_experiment(found("ambiguous", model("shrinkage", "wind"), model("adhesion", "shrinkage")))
    assert EFFECTS["wind"].varied in said
    assert EFFECTS["adhesion"].varied in said
    assert EFFECTS["shrinkage"].varied not in said


@pytest.mark.parametrize("pair", SEPARATING, ids=lambda pair: " and ".join(sorted(pair)))
def test_two_names_that_are_taken_for_each_other_are_told_apart_by_what_is_known_of_them(model, pair):
    first, second = sorted(pair)
    assert next_experiment(found("ambiguous", model(first), model(second))).endswith(f"and vary it: {SEPARATING[pair]}")


@pytest.mark.parametrize("pair", SEPARATING, ids=lambda pair: " and ".join(sorted(pair)))
def test_two_effects_that_were_named_together_need_no_telling_apart(model, pair):
    assert SEPARATING[pair] not in next_experiment(found("named", model(*sorted(pair))))


def test_what_is_left_or_unknown_asks_for_the_worst_motion_slower(model):
    for open_ in (
        found("unknown", model(swing_a=3.0)),
        found("named", model("air_drag", swing_a=3.0), misfit=2.0),
    ):
        assert next_experiment(open_).startswith("repeat swing_a, which is explained worst (mean square 3.0 times")
        assert "slower" in next_experiment(open_)


def test_a_search_that_was_stopped_asks_for_more_time(model):
    assert "more time" in next_experiment(found("unknown", model(), stopped=True))


def test_every_effect_says_what_to_vary_and_what_tells_two_apart_is_of_effects():
    assert all(effect.varied for effect in EFFECTS.values())
    assert set().union(*SEPARATING) <= set(EFFECTS)
