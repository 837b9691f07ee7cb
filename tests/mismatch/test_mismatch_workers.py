"""Who simulates what."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle

from sim1.mismatch.workers import Workers


def test_recordings_are_dealt_to_processes_by_their_length():
    bundle = empty_bundle(motions=4)
    lengths = dict(zip([one.name for one in bundle.recordings], (14.6, 8.0, 13.2, 7.7), strict=True))
    cut = tuple(replace(one, time_s=np.linspace(0.0, lengths[one.name], 50)) for one in bundle.recordings)
    workers = Workers(replace(bundle, recordings=cut), 2)
    workers._own(set(lengths))
    workers.close()
    loads = [sum(lengths[name] for name, process in workers._owner.items() if process == k) for k in range(2)]
    assert sorted(loads) == pytest.approx([21.2, 22.3])
