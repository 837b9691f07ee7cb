"""A recording promises half a second of rest: a grip that slips holds what a sheet at rest pulls with."""

import numpy as np
import pytest

from benchmarks.concealed.case import Case, Plan
from benchmarks.concealed.effects.library import LIBRARY
from benchmarks.concealed.film import Stage, film, grid_for
from benchmarks.concealed.markers import draw_markers
from benchmarks.concealed.motions import MOTIONS
from benchmarks.concealed.motions.pulling import taut_load_n
from benchmarks.concealed.setting import draw_setting

CASE = Case(("grip_slip",), "strong", 4)


@pytest.fixture(scope="module")
def pulled():
    """A taut sheet between clamps with a grip that slips fast, for 1.2 s."""
    setting = CASE.setting()
    grid, offsets = grid_for(setting), {"front": np.zeros(3), "back": np.zeros(3)}
    stage = Stage(setting, grid, draw_markers(setting, grid, CASE.stream("markers")), offsets).coarser()
    motion = MOTIONS["bars_pull"](setting.cloth, setting.columns, setting.rows, CASE.stream("motions"))
    return film(stage, Plan("a", motion, True, False), [slipping(setting, CASE.stream("grip_slip"))], 1.2)


def slipping(setting, rng):
    return LIBRARY["grip_slip"].draw(4.0, rng, setting)


def test_clamps_pull_at_rest_as_hard_as_is_said(pulled):
    setting = CASE.setting()
    assert np.linalg.norm(pulled.grip_load_n[400], axis=1) == pytest.approx(
        taut_load_n(setting.cloth, setting.rows), rel=0.04
    )


def test_the_cloth_rests_in_its_grips_for_half_a_second_and_creeps_then(pulled):
    assert np.abs(pulled.places_m[:500] - pulled.places_m[0]).max() < 2e-5
    assert pulled.grip_shift_m[:500].max() < 1e-9
    assert pulled.grip_shift_m[-1].max() > 1e-3


def test_no_sheet_at_rest_reaches_the_threshold():
    """Taut clamps pull harder than any other grip does at rest, several times the sheet's weight."""
    for seed in range(200):
        setting = draw_setting(np.random.default_rng(seed))
        resting = taut_load_n(setting.cloth, setting.rows)
        assert resting > 2 * setting.cloth.weight_n
        assert slipping(setting, np.random.default_rng(seed)).parameters["threshold"] > 1.2 * resting
