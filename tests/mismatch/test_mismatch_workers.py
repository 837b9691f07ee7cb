"""Who simulates what."""

import os
import signal
from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle, plain_world

from sim1.mismatch import workers as module
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


@pytest.fixture
def guesses(monkeypatch):
    """What each simulation in this process begins with: shapes near its motion, and near its rest."""
    told, simulate = [], module.simulate

    def spy(*args, guess=None, near=None, **kwargs):
        told.append((guess, near))
        return simulate(*args, guess=guess, near=near, **kwargs)

    monkeypatch.setattr(module, "simulate", spy)
    monkeypatch.setattr(module, "_BUNDLE", [empty_bundle(count=5, motions=1, duration_s=0.8)])
    for name in ("_SCENES", "_GOALS", "_MOTIONS"):
        monkeypatch.setattr(module, name, {})
    return told


def asked(finer=0, step_s=1 / 60, follow_hz=1.0):
    world = plain_world(module._BUNDLE[0])
    return module._work(
        Task(recording="swing_0", worlds=(world,), finer=finer, step_s=step_s, follow_hz=follow_hz)
    ).markers_m


@pytest.mark.parametrize("before", [{"finer": 0}, {"finer": 1, "follow_hz": 2.0}], ids=["coarser", "followed faster"])
def test_a_motion_that_is_new_on_a_mesh_begins_with_what_is_like_it_and_says_the_same(before, guesses):
    fresh = asked(finer=1)
    module._MOTIONS.clear()
    asked(**before)
    led = asked(finer=1)
    (fresh_guess, _), _, (guess, near) = guesses
    assert fresh_guess is None
    assert near is None  # rest is sought by itself
    assert guess.shape[1] == 81
    assert np.abs(led - fresh).max() < 1e-5


def test_a_motion_by_other_steps_begins_with_nothing(guesses):
    asked(step_s=1 / 60)
    asked(step_s=1 / 120)
    assert guesses[-1] == (None, None)


def test_a_motion_that_is_led_astray_is_sought_once_more_without(guesses, monkeypatch):
    asked()
    spy = module.simulate

    def fails(*args, guess=None, **kwargs):
        if guess is not None:
            raise module.NotConverged("led astray")
        return spy(*args, guess=guess, **kwargs)

    monkeypatch.setattr(module, "simulate", fails)
    assert asked(finer=1).shape[0] == 1
