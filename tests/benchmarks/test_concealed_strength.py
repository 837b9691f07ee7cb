"""An effect is made as strong as its case asks, also where what it does is not proportional to it."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.concealed import strength
from benchmarks.concealed.case import STRENGTHS, Case
from benchmarks.concealed.effects.library import LIBRARY
from benchmarks.concealed.setting import draw_setting
from benchmarks.concealed.strength import amplitudes, nearest_to_one, tuned

LIMITS = (0.02, 10.0)


def search(share_of, tries=6, usual=1.0):
    """The amplitude that is taken, and all that were tried."""
    tried = []

    def attempt(amplitude):
        tried.append(amplitude)
        return share_of(amplitude), amplitude

    return nearest_to_one(attempt, usual, LIMITS, tries), tried


@given(slope=st.floats(0.15, 30.0), power=st.floats(0.5, 2.0))
def test_a_smooth_answer_is_met_within_its_tolerance(slope, power):
    taken, _ = search(lambda a: slope * a**power, tries=8)
    if LIMITS[0] < slope ** (-1 / power) < LIMITS[1]:
        assert abs(np.log(slope * taken**power)) < np.log(1.4)


def test_a_usual_amplitude_that_does_is_kept():
    assert search(lambda a: 1.1 * a) == (1.0, [1.0])


def test_a_sheet_that_forks_gets_the_amplitude_that_comes_nearest_and_not_the_last_one():
    taken, tried = search(lambda a: 8.0 if a > 0.3 else 0.2 * a)
    assert 0.02 < min(tried) < 0.3 < max(tried)
    shares = [8.0 if a > 0.3 else 0.2 * a for a in tried]
    assert taken == tried[int(np.argmin(np.abs(np.log(shares))))]
    assert len(tried) == 6


@pytest.mark.parametrize(("slope", "end"), [(1e-3, 10.0), (1e3, 0.02)])
def test_what_is_out_of_reach_stops_at_the_end_of_its_range(slope, end):
    taken, tried = search(lambda a: slope * a)
    assert taken == end
    assert tried.count(end) == 1


FORETOLD_LIMIT = 3.5 / 4.8
"""Times the noise: single effects of medium strength lay at 4.8 times what a diagnosis said that shows, in the median."""


def test_weak_is_well_below_what_a_diagnosis_says_that_shows_and_medium_well_above():
    assert STRENGTHS["weak"] < FORETOLD_LIMIT / 2
    assert STRENGTHS["strong"] > STRENGTHS["medium"] > 2 * FORETOLD_LIMIT


@pytest.mark.parametrize("name", LIBRARY)
def test_a_weak_effect_may_be_as_small_as_it_must_and_others_keep_their_range(name):
    """Streams of air and friction that sticks are of medium strength at the smallest amplitude of their range."""
    low, high = LIBRARY[name].amplitudes
    assert amplitudes(name, "medium") == amplitudes(name, "strong") == (low, high)
    least, most = amplitudes(name, "weak")
    assert most == high
    assert least < low * STRENGTHS["weak"] / STRENGTHS["medium"]
    drawn = LIBRARY[name].draw(least, np.random.default_rng(1), draw_setting(np.random.default_rng(0)))
    assert np.isfinite(list(drawn.parameters.values())).all()


AMPLITUDES = {"air_drag": lambda p: p["c_normal"] / 1.4, "added_mass": lambda p: p["mass"] / 0.08}


class Imitating:
    """A scale by which an effect is as strong as its amplitude says, and `left` of that beside another one."""

    def __init__(self, case, left, beside=()):
        self.stage, self._case, self._left, self._beside = SimpleNamespace(setting=case.setting()), case, left, beside
        self.filmed = []

    def beside(self, name, effects):
        other = Imitating(self._case, self._left, {*self._beside, *([name] if effects else [])})
        other.filmed = self.filmed
        return other

    def rough_strength(self, name, effect):
        alone = AMPLITUDES[name](effect.parameters) * STRENGTHS[self._case.strength]
        return alone * (self._left if name in self._beside else 1.0)

    def strength(self, name, effect, films):
        return self.rough_strength(name, effect)

    def films(self, name, effect):
        self.filmed.append(name)
        return {}


@pytest.mark.parametrize(("left", "films"), [(0.3, 2), (0.9, 1)])
def test_the_first_of_a_pair_is_made_stronger_where_the_second_imitates_it_and_stays_where_not(
    monkeypatch, left, films
):
    case = Case(("air_drag", "added_mass"), "medium", 0)
    scale = Imitating(case, left)
    monkeypatch.setattr(strength, "scale_of", lambda *given: scale)
    effects, _, strengths = tuned(case, scale.stage, [], {})
    assert [effect.name for effect in effects] == list(case.effects)
    assert np.abs(np.log(np.divide(strengths, STRENGTHS["medium"]))).max() < np.log(1.4)
    assert scale.filmed.count("air_drag") == films
