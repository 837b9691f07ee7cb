"""Where a search is held up by a fold of the cost, and what begins beyond it."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from straight_engine import TRUE, Straight, two_unknowns

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.afresh import HELD_UP, afresh
from sim1.mismatch.fit import fit, promised

TEMPER = {"only": 1.0}


@dataclass
class Folded(Straight):
    """Straight, with a fold that no slope tells: small values of the second unknown, the effect's strength, cost more."""

    fold: tuple[float, float] = (1e-3, 0.35)

    def residuals(self, unknowns, z, names):
        found = super().residuals(unknowns, z, names)
        inside = self.fold[0] < abs(z[1]) < self.fold[1]
        return {name: one + np.where(inside, 40.0 * np.sign(one), 0.0) for name, one in found.items()}


@pytest.fixture
def base():
    """A baseline, the first unknown alone; the second is what comes in."""
    known = two_unknowns()
    alone = replace(known, nominal=known.nominal[:1])
    found = fit(Straight(), known, np.array([TRUE[0], 0.0]), ("only",), temper=TEMPER, most=0)
    return replace(found, unknowns=alone, z=found.z[:1])


def screened(base, strength, gain=0.0):
    """What a screening beside the baseline says of the effect."""
    return SimpleNamespace(gain=gain, start=np.append(base.z, strength))


@pytest.fixture
def stuck(base):
    """The effect's model, held up at no strength: a whole step leads to the other side of the fold, and is not taken."""
    return fit(Folded(fold=(1e-3, 0.6)), two_unknowns(), np.array([base.z[0], 0.0]), ("only",), temper=TEMPER)


def test_a_search_that_a_fold_holds_up_goes_on_from_a_usual_strength_beyond_it(base, stuck):
    assert stuck.converged
    assert promised(stuck) > HELD_UP
    found = afresh(Folded(), base, stuck, screened(base, -0.05))
    assert found.z == pytest.approx(TRUE, abs=0.02)
    assert found.cost < stuck.cost - HELD_UP


def test_so_does_one_that_gained_little_of_what_the_screening_foretold(base):
    flat = fit(Folded(fold=(1e-3, np.inf)), two_unknowns(), np.append(base.z, 0.0), ("only",), temper=TEMPER, most=0)
    flat = replace(flat, slopes={"only": 0.0 * flat.slopes["only"]})
    assert promised(flat) < HELD_UP
    assert afresh(Folded(), base, flat, screened(base, -0.05, gain=HELD_UP / 2)) is flat
    assert afresh(Folded(), base, flat, screened(base, -0.05, gain=2 * HELD_UP)).z == pytest.approx(TRUE, abs=0.02)


def test_what_begins_afresh_and_ends_no_better_is_left(base, stuck):
    assert afresh(Folded(fold=(1e-3, np.inf)), base, stuck, screened(base, -0.05)) is stuck


def test_nothing_begins_afresh_that_promises_little_or_less_than_it_gained_or_has_no_strength_to_go_by(base, stuck):
    engine, start = Folded(), screened(base, -0.05)
    ended = fit(Straight(), two_unknowns(), np.zeros(2), ("only",), temper=TEMPER)
    far_behind = fit(Straight(), two_unknowns(), np.array([9.0, 9.0]), ("only",), temper=TEMPER, most=0)
    assert afresh(engine, base, ended, start) is ended
    assert afresh(engine, replace(far_behind, unknowns=base.unknowns), stuck, start) is stuck
    assert afresh(engine, base, stuck, screened(base, 0.0)) is stuck
    assert engine.looks == 0


def test_usual_strengths_that_no_simulation_follows_are_left(base, stuck):
    engine = Folded(border=0.9)
    with pytest.raises(NotConverged):
        engine.residuals(two_unknowns(), np.array([base.z[0], -1.0]), ("only",))
    assert afresh(engine, base, stuck, screened(base, -0.05)) is stuck
