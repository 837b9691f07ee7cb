"""Which recording tests what the others taught."""

from dataclasses import replace

import pytest
from small_bundle import empty_bundle

from sim1.mismatch.heldout import held_out
from sim1.recording.bundle import write_bundle
from sim1.recording.examination import examine


def gripped_elsewhere(bundle, name):
    """The bundle with one recording whose cloth is held by other vertices than in the rest."""
    recordings = []
    for recording in bundle.recordings:
        if recording.name == name:
            hold = replace(recording.holds[0], drive="other", vertices=recording.holds[0].vertices + 7)
            recording = replace(recording, holds=(hold,), drives={"other": recording.drives["bar"]})
        recordings.append(recording)
    return replace(bundle, recordings=tuple(recordings))


@pytest.mark.parametrize("measured", [True, False])
def test_the_motion_most_like_anothers_is_held_out_unless_nothing_tells_how_it_is_gripped(measured):
    bundle = empty_bundle(motions=4, measured=measured)
    alike = held_out(bundle)
    chosen = held_out(gripped_elsewhere(bundle, alike))
    assert (chosen == alike) is measured


def test_where_every_recording_has_grips_of_its_own_one_is_held_out_all_the_same():
    bundle = empty_bundle(motions=2, measured=False)
    assert held_out(gripped_elsewhere(bundle, "swing_0")) in {"swing_0", "swing_1"}


def let_go(bundle, *names):
    """The bundle with recordings in which nothing holds the cloth."""
    parts = (replace(one, holds=()) if one.name in names else one for one in bundle.recordings)
    return replace(bundle, recordings=tuple(parts))


def test_what_nothing_holds_is_held_out_only_where_there_are_not_two_others():
    bundle = empty_bundle(motions=4)
    everywhere = [held_out(let_go(bundle, f"swing_{k}")) for k in range(4)]
    assert all(chosen != f"swing_{k}" for k, chosen in enumerate(everywhere))
    assert held_out(let_go(bundle, "swing_0", "swing_1")) in {"swing_2", "swing_3"}
    assert held_out(let_go(bundle, "swing_0", "swing_1", "swing_2")) == "swing_2"  # the one held motion teaches
    assert held_out(let_go(bundle, *(one.name for one in bundle.recordings))) == "swing_3"


@pytest.mark.parametrize("loose", [(), ("swing_0",), ("swing_0", "swing_1", "swing_2")])
def test_another_is_held_out_in_place_of_one_that_is_to_be_fitted(loose):
    bundle = let_go(empty_bundle(motions=4), *loose)
    first = held_out(bundle)
    second = held_out(bundle, but=first)
    assert second != first
    assert second in {one.name for one in bundle.recordings}
    assert (second in loose) is (len(loose) == 3)


def test_a_bundle_in_which_nothing_is_held_is_examined_like_any_other(tmp_path):
    bundle = empty_bundle(motions=3)
    write_bundle(tmp_path / "b", let_go(bundle, "swing_1"))
    found = examine(tmp_path / "b")
    assert found.problems == ()
    assert [one.hold_count for one in found.recordings] == [1, 0, 1]
