"""What a verdict says besides."""

import pytest

from sim1.mismatch.foretold import Foretold
from sim1.mismatch.remarks import had_a_say, not_foretold


def test_motion_held_out_that_changed_nothing_has_had_no_say():
    assert list(had_a_say(("swing_b",), (), ())) == []


@pytest.mark.parametrize(
    ("spoken_for", "withdrawn", "said"),
    [(("adhesion",), (), "decided for adhesion"), ((), ("wind", "added_mass"), "decided against wind and added_mass")],
)
def test_an_error_held_out_is_told_to_be_of_a_model_that_this_motion_helped_to_choose(spoken_for, withdrawn, said):
    (remark,) = had_a_say(("swing_b",), spoken_for, withdrawn)
    assert remark.startswith("swing_b, which no fit saw, ")
    assert said in remark
    assert remark.endswith("the error there is of a model that it helped to choose")


def test_a_recording_that_no_simulation_follows_is_told_once_where_nothing_was_chosen():
    baseline = Foretold(markers_m={}, lost={"snap": "stopped at 1.2 s"})
    other = Foretold(markers_m={}, lost={"snap": "stopped at 1.3 s"})
    assert len(list(not_foretold({"baseline": baseline, "augmented": baseline}))) == 1
    told = list(not_foretold({"baseline": baseline, "augmented": other}))
    assert [line.split(" from ")[0] for line in told] == [
        "snap cannot be foretold with the calibrated baseline",
        "snap cannot be foretold with the model",
    ]
