"""Markers that wander over the cloth are told from what no cloth can do."""

from dataclasses import replace

import numpy as np
import pytest
from swinging import ROW, board_bundle, coloured, swing

from sim1.recording.bundle import write_bundle
from sim1.recording.creep import creep_m
from sim1.recording.examination import examine

RATE_HZ = 30.0


def wandering(name, std_m, *, seed=0, **how):
    """A swing whose markers wander by so much once it has begun to move, and forget it within a second."""
    recording = swing(name, rate_hz=RATE_HZ, noise_m=5e-4, seed=seed, **how)
    wander = std_m * coloured(np.random.default_rng(seed + 1), recording.markers_m.shape, RATE_HZ)
    moves = (recording.time_s > 1.0)[:, None, None]
    return replace(recording, markers_m=recording.markers_m + wander * moves)


def gripped_twice(recording):
    """The same with its lower edge in a second grip."""
    [hold] = recording.holds
    lower = replace(hold, drive="low", vertices=hold.vertices + ROW * (ROW - 1))
    return replace(recording, holds=(hold, lower), drives={**recording.drives, "low": recording.drives["bar"]})


@pytest.mark.parametrize("std_m", [2e-3, 5e-3])
def test_the_size_of_the_creep_is_told(std_m):
    bundle = board_bundle(wandering("a", std_m), wandering("b", std_m, seed=7, peak_rad_s=1.0))
    assert creep_m(bundle) == pytest.approx(std_m, rel=0.3)


def test_markers_that_keep_their_places_do_not_creep_however_noisy_they_are():
    assert creep_m(board_bundle(swing("a"))) == 0.0
    assert creep_m(board_bundle(swing("a", noise_m=2e-3), swing("b", noise_m=2e-3, seed=3))) == 0.0


def test_cloth_that_two_grips_could_pull_longer_tells_nothing():
    alone = wandering("a", 4e-3)
    assert creep_m(board_bundle(gripped_twice(alone))) is None
    assert creep_m(board_bundle(gripped_twice(alone), wandering("b", 4e-3, seed=5))) > 2e-3


def test_the_check_does_not_say_that_markers_stay_where_nothing_tells(tmp_path):
    write_bundle(tmp_path / "twice", board_bundle(gripped_twice(swing("a")), gripped_twice(swing("b", seed=3))))
    assert not [s for s in examine(tmp_path / "twice").statements if "stay where they are" in s.text]


def test_the_check_says_by_how_much_markers_creep(tmp_path):
    write_bundle(tmp_path / "wander", board_bundle(wandering("a", 4e-3), wandering("b", 4e-3, seed=5)))
    write_bundle(tmp_path / "keep", board_bundle(swing("a"), swing("b", peak_rad_s=1.0)))
    [said] = [s for s in examine(tmp_path / "wander").statements if "creep" in s.text]
    assert not said.can
    assert " mm" in said.text
    [said] = [s for s in examine(tmp_path / "keep").statements if "stay where they are" in s.text]
    assert said.can
