"""A recording held out that is not explained is fitted, too, and the contest held afresh."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from small_bundle import empty_bundle, filmed
from small_pool import pool_of

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch import rounds as module
from sim1.mismatch.decide import Decision
from sim1.mismatch.diagnose import diagnose
from sim1.mismatch.judging import Judgement
from sim1.mismatch.patience import Patience
from sim1.mismatch.remarks import explains_heldout
from sim1.mismatch.rounds import STOPPED, rounds
from sim1.mismatch.thresholds import THRESHOLDS
from sim1.mismatch.unfitted import NOTHING

ENOUGH = THRESHOLDS.misfit_alone


class Rehearsed:
    """Contests that were held beforehand: how large a mean square each recording is left with, held out."""

    def __init__(self, monkeypatch, left, misfit=1.0, motions=4):
        self.left, self.misfit, self.patience, self.told = left, misfit, Patience(), []
        self.bundle = empty_bundle(motions=motions)
        self.names = tuple(one.name for one in self.bundle.recordings)
        self.fitted, self.heard = [], NOTHING
        self.ends = lambda: None  # what happens while the second contest is held
        monkeypatch.setattr(module, "contest", self._contest)
        monkeypatch.setattr(module, "judge", self._judge)
        monkeypatch.setattr(module, "left_by", self._left_by)

    def _contest(self, engine, plain, fitted, thresholds, progress, calibrated):
        self.fitted.append(fitted)
        progress(0.5, "halfway")
        if len(self.fitted) == 2:
            self.ends()
        return SimpleNamespace(pool=[])

    def _judge(self, engine, pool, heldout, thresholds, measured, *, stopped):
        [null] = pool_of(None, {}, {(): self.misfit})
        said = Decision(verdict="none", null=null, chosen=null, rivals=(), misfit={})
        return Judgement(decision=said, by_fits=said, heard=self.heard, hopeful=())

    def _left_by(self, engine, model, heard, names):
        left = self.left[names[0]]
        if left is None:
            raise NotConverged(f"recording {names[0]}: no next state at 0.5 s")
        return {names[0]: np.full(50, np.sqrt(left))}

    def __call__(self):
        progress = lambda share, what: self.told.append(share)  # noqa: E731
        return rounds(self, self.bundle, THRESHOLDS, frozenset(), progress, lambda base: None)

    def remarks(self):
        return list(explains_heldout(self(), THRESHOLDS))


def left(**unusual):
    return dict.fromkeys((f"swing_{k}" for k in range(4)), 1.0) | unusual


@pytest.fixture
def first(monkeypatch):
    """The recording that is held out first, and the one after it."""
    held = Rehearsed(monkeypatch, left())().last.heldout[0]
    again = Rehearsed(monkeypatch, left(**{held: 2.0 * ENOUGH}))()
    return held, again.last.heldout[0]


def test_a_recording_that_is_explained_stays_held_out(monkeypatch):
    rehearsed = Rehearsed(monkeypatch, left())
    found = rehearsed()
    assert found.taught_by is None
    assert found.last.left == pytest.approx(1.0)
    assert set(rehearsed.fitted[0]) == set(rehearsed.names) - set(found.last.heldout)
    assert rehearsed.remarks() == []


def test_one_that_is_not_is_fitted_and_another_held_out(monkeypatch, first):
    rehearsed = Rehearsed(monkeypatch, left(**{first[0]: 2.0 * ENOUGH}))
    found = rehearsed()
    assert first[0] in rehearsed.fitted[1]
    assert found.last.fitted == rehearsed.fitted[1]
    assert set(rehearsed.names) - set(rehearsed.fitted[1]) == {first[1]}
    assert rehearsed.told[0] < rehearsed.told[2] < rehearsed.told[-1] == 1.0
    [remark] = explains_heldout(found, THRESHOLDS)
    assert remark.startswith(f"{first[0]}, held out at first, was left at {2.0 * ENOUGH:.1f} times its variance")
    assert remark.endswith(f"it was fitted, too, and {first[1]} held out in its place")


def test_there_is_no_third_round_and_what_is_not_explained_then_is_told(monkeypatch, first):
    rehearsed = Rehearsed(monkeypatch, dict.fromkeys(left(), 2.0 * ENOUGH))
    _, remark = rehearsed.remarks()
    assert len(rehearsed.fitted) == 2
    assert remark.startswith(f"{first[1]}, which no fit saw, is left at ")
    assert "something shows there" in remark


def test_of_two_recordings_neither_can_be_spared(monkeypatch):
    rehearsed = Rehearsed(monkeypatch, dict.fromkeys(left(), 2.0 * ENOUGH), motions=2)
    [remark] = rehearsed.remarks()
    assert len(rehearsed.fitted) == 1
    assert remark.endswith("does not explain")


def test_a_model_that_leaves_more_than_noise_where_it_was_fitted_is_no_witness(monkeypatch):
    rehearsed = Rehearsed(monkeypatch, dict.fromkeys(left(), 2.0 * ENOUGH), misfit=1.1 * THRESHOLDS.misfit)
    found = rehearsed()
    assert (found.last.left, found.taught_by) == (None, None)


def test_a_second_round_that_is_interrupted_changes_nothing(monkeypatch, first):
    rehearsed = Rehearsed(monkeypatch, left(**{first[0]: 2.0 * ENOUGH}))
    rehearsed.ends = rehearsed.patience.interrupt
    found = rehearsed()
    assert found.last.heldout == (first[0],)
    assert found.stopped
    [remark] = explains_heldout(found, THRESHOLDS)
    assert remark.endswith(f"a search that fits it, too, came to no end ({STOPPED})")


def test_nor_does_one_that_no_simulation_follows(monkeypatch, first):
    rehearsed = Rehearsed(monkeypatch, left(**{first[0]: 2.0 * ENOUGH}))

    def ends():
        raise NotConverged("recording swing_0: no rest")

    rehearsed.ends = ends
    found = rehearsed()
    assert found.last.heldout == (first[0],)
    assert not found.stopped
    [remark] = explains_heldout(found, THRESHOLDS)
    assert "came to no end (recording swing_0: no rest)" in remark


def test_what_no_simulation_follows_is_told_not_to_be_known(monkeypatch, first):
    rehearsed = Rehearsed(monkeypatch, left(**{first[0]: None}))
    [remark] = rehearsed.remarks()
    assert (
        remark
        == f"whether {first[0]}, which no fit saw, is explained is not known: recording {first[0]}: no next state at 0.5 s"
    )


def driven(bundle, **drives):
    """The bundle with another motion of the bar in some recordings: position (T, 3) over time (T,)."""
    recordings = []
    for one in bundle.recordings:
        track = one.drives["bar"]
        moved = replace(track, position_m=drives[one.name](track.time_s))
        recordings.append(replace(one, drives={"bar": moved}))
    return replace(bundle, recordings=tuple(recordings))


def swing(size_m, hz, height_m=0.6):
    """A bar that swings across, beginning and ending at rest."""

    def position(time_s):
        run = np.clip((time_s - 0.4) / 1.4, 0.0, 1.0)
        across = size_m * np.sin(np.pi * run) ** 2 * np.sin(2 * np.pi * hz * (time_s - 0.4))
        return np.column_stack([0.0 * time_s, across, height_m + 0.0 * time_s])

    return position


@pytest.mark.slow
def test_an_effect_that_only_the_recording_held_out_first_shows_is_named():
    drives = {"swing_0": swing(0.002, 0.6), "swing_1": swing(0.002, 0.7, 0.9), "swing_2": swing(0.04, 1.6)}
    bundle = filmed(driven(empty_bundle(), **drives), air_normal=3.0)
    found = diagnose(bundle)
    assert found.heldout != ("swing_2",)
    assert found.chosen.terms == ("air_drag",)
    assert any(remark.startswith("swing_2, held out at first") for remark in found.remarks)
