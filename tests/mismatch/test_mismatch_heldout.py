"""Which recording tests what the others taught."""

from dataclasses import replace

import pytest
from small_bundle import empty_bundle

from sim1.mismatch.heldout import held_out


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
