"""A leader that acts above a threshold alone, looked at with other thresholds than screening chose."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from straight_engine import Straight, two_unknowns

from sim1.cloth.effects import EFFECTS, Effect
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.elsewhere import elsewhere
from sim1.mismatch.fit import PROMISING, fit

TEMPER, HIGH = {"only": 1.0}, 8.0


class Creep(Effect):
    """Stands for an effect with a rate and a threshold."""

    name = "creep"
    beyond = True
    coefficients = (
        Coefficient(name="rate", unit="1", scale=1.0, low=0.0),
        Coefficient(name="threshold", unit="1", scale=0.1, kind="log", centre=1.0, shape=True),
    )

    @classmethod
    def alter(cls, world, values):
        return world

    @classmethod
    def variants(cls, site):
        return [{"threshold": start} for start in (0.5, 1.0, HIGH, 20.0)]


class Slack(Straight):
    """Only with a threshold near the high one a rate of 1 explains everything; below it a trace helps, above it nothing is followed."""

    def residuals(self, unknowns, z, names):
        values = unknowns.values(0, z)
        if values["threshold"] > 2 * HIGH:
            raise NotConverged("recording only: no next state at 1 s")
        rate, near = values["rate"], abs(np.log(values["threshold"] / HIGH)) < 0.5
        left = abs(1.0 - rate) if near else 1.0 + (rate - 0.2) ** 2
        return {"only": left * np.full(300, 1.5) + 0.1}

    def slopes(self, unknowns, z, names, first=0):
        now, found = self.residuals(unknowns, z, names)["only"], []
        for place in range(first, len(z)):
            moved = z.copy()
            moved[place] += 1e-4 if z[place] < 1.0 else -1e-4
            found.append((self.residuals(unknowns, moved, names)["only"] - now) / (moved[place] - z[place]))
        return {"only": now}, {"only": np.stack(found, axis=1)}


@pytest.fixture
def base():
    unknowns = two_unknowns()
    found = fit(Straight(), unknowns, np.zeros(2), ("only",), temper=TEMPER, most=0)
    return replace(found, residuals={"only": np.full(300, 2.0)})


@pytest.fixture
def low(base):
    """What a search from the low threshold ends with."""
    term = SimpleNamespace(effect=Creep, coefficients=Creep.coefficients)
    unknowns = base.unknowns.with_terms(term)
    return fit(Slack(), unknowns, np.array([0.0, 0.0, 0.2, 0.0]), ("only",), temper=TEMPER, most=0)


def candidate(effect=Creep):
    return SimpleNamespace(term=SimpleNamespace(effect=effect))


def test_a_high_rate_above_a_high_threshold_is_found_where_a_trace_pointed_to_a_low_one(base, low):
    assert base.cost - low.cost > PROMISING
    found = elsewhere(Slack(), base, low, candidate(), None)
    values = found.unknowns.values(0, found.z)
    assert values["threshold"] == pytest.approx(HIGH, rel=0.1)
    assert values["rate"] == pytest.approx(1.0, abs=0.1)
    assert found.cost < low.cost - PROMISING


def test_a_leader_that_fits_better_than_any_other_threshold_would_is_left(base, low):
    better = replace(low, residuals={"only": np.zeros(300)})
    assert elsewhere(Slack(), base, better, candidate(), None) is better


def test_nothing_else_is_looked_at_beside_what_gains_little_or_has_no_threshold(base, low):
    little = replace(base, residuals=low.residuals)

    class Nowhere:
        """Whoever asks it anything fails."""

    assert elsewhere(Nowhere(), little, low, candidate(), None) is low
    assert elsewhere(Nowhere(), base, low, candidate(EFFECTS["air_drag"]), None) is low
