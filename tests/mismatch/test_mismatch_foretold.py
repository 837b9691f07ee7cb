"""What a model foretells from rest and drives alone."""

from types import SimpleNamespace

import numpy as np

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.foretold import foretold_by


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
