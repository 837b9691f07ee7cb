"""What a model foretells from rest and drives alone."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from small_bundle import PRIOR, empty_bundle

from sim1.cloth.physics import ClothPhysics, Property
from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.foretold import foretold_by
from sim1.mismatch.predict import predict
from sim1.stage import BadInput


def test_a_model_that_no_simulation_follows_is_told_apart_and_the_others_are_asked():
    """Wind leads the sheet where no next state is found; the other models and recordings are none the worse."""
    told = {
        ("swing_0", 0.0): np.ones((4, 2, 3)),
        ("swing_1", 0.0): NotConverged("recording swing_1: no next state at 0.700 s"),
    }
    engine = SimpleNamespace(foretold=lambda world, names: {name: told[name, world] for name in names})
    model = SimpleNamespace(fit=SimpleNamespace(unknowns=SimpleNamespace(world=lambda z: 0.0), z=None))
    found = foretold_by(engine, model, ("swing_0", "swing_1"))
    assert list(found.markers_m) == ["swing_0"]
    assert found.lost == {"swing_1": "recording swing_1: no next state at 0.700 s"}


def test_a_recording_that_ends_before_its_clock_begins_is_named():
    """As of a camera that counts up to its trigger: motion is foretold from 0 s on."""
    bundle = empty_bundle(motions=1)
    one = bundle.recordings[0]
    drives = {name: replace(track, time_s=track.time_s - 6.0) for name, track in one.drives.items()}
    holds = tuple(replace(hold, from_s=hold.from_s - 6.0, to_s=hold.to_s - 6.0) for hold in one.holds)
    early = replace(one, time_s=one.time_s - 6.0, drives=drives, holds=holds)
    physics = ClothPhysics(**{name: Property(value=prior["value"]) for name, prior in PRIOR.items()})
    with pytest.raises(
        BadInput, match=r"swing_0/drives\.parquet: ends at -4 s, and motion is foretold from 0 s on: add"
    ):
        predict(replace(bundle, recordings=(early,)), physics)
