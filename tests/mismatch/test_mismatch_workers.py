"""Who simulates what."""

import os
import signal
from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle, plain_world

from sim1.mismatch.workers import Task, Workers


def test_recordings_are_dealt_to_processes_by_their_length():
    bundle = empty_bundle(motions=4)
    lengths = dict(zip([one.name for one in bundle.recordings], (14.6, 8.0, 13.2, 7.7), strict=True))
    cut = tuple(replace(one, time_s=np.linspace(0.0, lengths[one.name], 50)) for one in bundle.recordings)
    workers = Workers(replace(bundle, recordings=cut), 2)
    workers._own(set(lengths))
    workers.close()
    loads = [sum(lengths[name] for name, process in workers._owner.items() if process == k) for k in range(2)]
    assert sorted(loads) == pytest.approx([21.2, 22.3])


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_process_that_is_told_to_end_still_answers_its_parent_which_needs_it_to_report_what_is_known(number):
    bundle = empty_bundle(count=5, motions=1, duration_s=0.8)
    asked = [Task(recording="swing_0", worlds=(plain_world(bundle),), finer=0, step_s=1 / 60)]
    workers = Workers(bundle, 1)
    before = workers(asked)[0].markers_m
    [process] = workers._pools[0]._processes
    os.kill(process, number)
    after = workers(asked)[0].markers_m
    workers.close()
    assert np.allclose(before, after, atol=1e-5)
