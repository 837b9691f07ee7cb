"""The laboratory films every case that is drawn: where its steps are too long, it takes shorter ones."""

from typing import ClassVar

import numpy as np
import pytest

from benchmarks.concealed import film as filming
from benchmarks.concealed.simulate import Course


class Unstable:
    """A simulation that stays finite by steps of `longest` of the usual ones or less."""

    longest = 1.0
    asked: ClassVar[list[float]] = []

    def __init__(self, world, effects, step_scale):
        self.step_scale = step_scale
        self.asked.append(step_scale)

    def run(self, duration_s: float, missing: bool) -> Course:
        """Its step in place of a time."""
        if self.step_scale > self.longest:
            raise FloatingPointError("swing with stiff_region became unstable")
        none = np.zeros((0, 3))
        return Course(np.array([self.step_scale]), none, none, none, none, 0.0)


@pytest.fixture
def simulation(monkeypatch):
    """In place of the laboratory's own."""
    monkeypatch.setattr(filming, "Simulation", Unstable)
    monkeypatch.setattr(Unstable, "asked", [])
    return Unstable


@pytest.mark.parametrize(("longest", "tried"), [(1.0, [1.0]), (0.6, [1.0, 0.5]), (0.3, [1.0, 0.5, 0.25])])
def test_a_film_is_of_the_longest_steps_that_stay_finite(simulation, monkeypatch, longest, tried):
    monkeypatch.setattr(simulation, "longest", longest)
    assert filming.course(None, (), 4.0).times_s == [tried[-1]]
    assert simulation.asked == tried


def test_what_no_step_keeps_finite_is_told(simulation, monkeypatch):
    monkeypatch.setattr(simulation, "longest", 0.1)
    with pytest.raises(FloatingPointError, match="swing with stiff_region"):
        filming.course(None, (), 4.0)
