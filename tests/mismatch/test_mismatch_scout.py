"""Where a search on the coarser mesh sends one on the working mesh."""

from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
import pytest
from straight_engine import TRUE, Straight, two_unknowns

from sim1.mismatch.fit import fit
from sim1.mismatch.scout import further, scouted

TEMPER = {"only": 1.0}
MOVES = np.array([0.25, 0.0])  # the coarser mesh: what its error is taken for in the baseline's coefficient


@dataclass
class Meshed(Straight):
    """Straight, on two meshes; a step on the coarser one is counted, too."""

    finer: int = 1
    rough_looks: int = 0

    @property
    def other_mesh(self):
        return 1 - self.finer

    @contextmanager
    def roughly(self):
        self.finer = 0
        yield
        self.finer = 1

    def slopes(self, unknowns, z, names, first=0):
        self.rough_looks += self.finer == 0
        own = z if len(z) == 2 else np.append(z, 0.0)
        residuals, slopes = super().slopes(unknowns, own, names, first)
        return residuals, {name: one[:, : len(z) - first] for name, one in slopes.items()}

    def residuals(self, unknowns, z, names):
        own = z if len(z) == 2 else np.append(z, 0.0)
        return super().residuals(unknowns, own if self.finer else own - MOVES, names)


@pytest.fixture
def engine():
    return Meshed()


@pytest.fixture
def base(engine):
    """A baseline, the first unknown alone, with the second, the effect's strength, at nothing."""
    known = two_unknowns()
    return fit(engine, replace(known, nominal=known.nominal[:1]), np.zeros(1), ("only",), temper=TEMPER)


@pytest.fixture
def look(engine, base):
    return fit(engine, two_unknowns(), np.append(base.z, -0.02), ("only",), temper=TEMPER, most=0)


def test_a_leader_goes_on_from_where_the_coarser_mesh_leads_less_what_that_moves_the_baseline_by(engine, base, look):
    [start] = scouted(engine, base, [look])
    assert start == pytest.approx(TRUE, abs=0.2 * MOVES[0])
    assert engine.finer == 1
    found = further(engine, look, start, most=0)
    assert found.z.tolist() == start.tolist()
    assert found.cost < look.cost - 100.0


def test_where_that_costs_more_than_the_first_look_the_search_goes_on_from_there(engine, look):
    assert further(engine, look, np.array([9.0, 9.0]), most=0).z.tolist() == look.z.tolist()
    assert further(engine, look, None, most=0).z.tolist() == look.z.tolist()
    engine.border = 1.0
    assert further(engine, look, np.array([9.0, 9.0]), most=0).z.tolist() == look.z.tolist()
    assert further(engine, look, None, most=4).z == pytest.approx(TRUE, abs=0.02)


def test_nothing_is_scouted_where_the_other_mesh_is_finer_or_follows_nothing_or_time_is_over(engine, base, look):
    engine.border = 0.1
    assert scouted(engine, base, [look, look]) == [None, None]
    engine.border, looks = np.inf, engine.rough_looks
    engine.finer = 0
    assert scouted(engine, base, [look]) == [None]
    engine.finer = 1
    engine.patience.interrupt()
    assert scouted(engine, base, [look]) == [None]
    assert engine.rough_looks == looks
