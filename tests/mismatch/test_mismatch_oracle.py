"""The oracle of a proof starts where the answers say: the fabric, the effects, and a frame that is told about the origin."""

import numpy as np
import pytest
from small_bundle import empty_bundle

from sim1.proof.oracle import as_told

FRAME = {"tx": 0.004, "ty": -0.002, "tz": 0.003, "rx": 0.02, "ry": -0.01, "rz": 0.005}


def test_the_oracle_starts_from_what_was_concealed():
    model, z = as_told(empty_bundle(), {"frame_offset": FRAME, "clock_offset": {"offset": 0.05}}, {"poisson": 0.25})
    world = model.world(z)
    assert world.frame_shift_m == pytest.approx([FRAME[name] for name in ("tx", "ty", "tz")])
    assert world.frame_turn_rad == pytest.approx([FRAME[name] for name in ("rx", "ry", "rz")])
    assert world.clock_offset_s == pytest.approx(0.05)
    assert world.poisson == pytest.approx(0.25)


def test_what_answers_do_not_tell_starts_at_its_prior():
    model, z = as_told(empty_bundle(), {}, {})
    assert z == pytest.approx(np.zeros(model.count))
