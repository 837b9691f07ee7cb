"""Where a search on the coarser mesh sends one on the working mesh."""

from contextlib import contextmanager
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from straight_engine import TRUE, Straight, two_unknowns

from sim1.cloth.effects import EFFECTS
from sim1.mismatch import models, scout
from sim1.mismatch.fit import fit
from sim1.mismatch.patience import Patience
from sim1.mismatch.scout import Scouted, further, scouted
from sim1.mismatch.screen import Candidate
from sim1.mismatch.search import Term, Unknowns

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


def screened(base, strength=0.0, gain=0.0):
    """What a screening beside the baseline says of the effect."""
    return SimpleNamespace(gain=gain, start=np.append(base.z, strength))


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
    [start] = scouted(engine, base, [look], [screened(base)])
    assert start.z == pytest.approx(TRUE, abs=0.2 * MOVES[0])
    assert start.gain == pytest.approx(
        base.cost - fit(engine, look.unknowns, TRUE, ("only",), temper=TEMPER).cost, rel=0.1
    )
    assert engine.finer == 1
    found = further(engine, look, start, most=0)
    assert found.z.tolist() == start.z.tolist()
    assert found.cost < look.cost - 100.0


def test_a_search_on_the_coarser_mesh_that_a_fold_holds_up_begins_once_more_beyond_it(engine, base, look, monkeypatch):
    asked, candidate = [], screened(base)

    def freed(engine, rough, stuck, candidate):
        asked.append((engine.finer, rough.z - base.z, candidate))
        return replace(stuck, z=stuck.z + 0.1)

    [plain] = scouted(engine, base, [look], [candidate])
    monkeypatch.setattr(scout, "afresh", freed)
    [start] = scouted(engine, base, [look], [candidate])
    [(finer, moved, told)] = asked
    assert (finer, told) == (0, candidate)
    assert moved == pytest.approx(MOVES[:1], abs=0.05)
    assert start.z == pytest.approx(plain.z + 0.1)


@pytest.mark.parametrize(("gain", "taken"), [(29.0, []), (31.0, ["air_drag"]), (None, ["air_drag"])])
def test_who_gains_too_little_on_the_coarser_mesh_goes_no_further(gain, taken, base, look, monkeypatch):
    one = Candidate(term=Term.of(EFFECTS["air_drag"]), gain=100.0, start=look.z, variants=1)
    went = []

    def on(engine, fit, start, most):
        went.append("air_drag")
        return fit

    monkeypatch.setattr(Unknowns, "world", lambda *_: None)
    monkeypatch.setattr(models, "site_of", lambda *_: None)
    monkeypatch.setattr(models, "screen", lambda *_: [one])
    monkeypatch.setattr(models, "_looked_at", lambda *_: models.judged(look, TEMPER))
    monkeypatch.setattr(models, "scouted", lambda *_: [gain and Scouted(z=look.z, gain=gain)])
    monkeypatch.setattr(models, "further", on)
    monkeypatch.setattr(models, "afresh", lambda engine, base, found, candidate: found)
    monkeypatch.setattr(models, "elsewhere", lambda engine, base, found, candidate, site: found)
    engine = SimpleNamespace(patience=Patience())
    tried = models.extended(engine, base, TEMPER, ("only",), lambda share, name: None, least=30.0)
    assert went == taken
    assert [model.fit.cost for model in tried.models] == [look.cost]


def test_where_that_costs_more_than_the_first_look_the_search_goes_on_from_there(engine, look):
    far = Scouted(z=np.array([9.0, 9.0]), gain=100.0)
    assert further(engine, look, far, most=0).z.tolist() == look.z.tolist()
    assert further(engine, look, None, most=0).z.tolist() == look.z.tolist()
    engine.border = 1.0
    assert further(engine, look, far, most=0).z.tolist() == look.z.tolist()
    assert further(engine, look, None, most=4).z == pytest.approx(TRUE, abs=0.02)


def test_nothing_is_scouted_where_the_other_mesh_is_finer_or_follows_nothing_or_time_is_over(engine, base, look):
    engine.border = 0.1
    assert scouted(engine, base, [look, look], [screened(base)] * 2) == [None, None]
    engine.border, looks = np.inf, engine.rough_looks
    engine.finer = 0
    assert scouted(engine, base, [look], [screened(base)]) == [None]
    engine.finer = 1
    engine.patience.interrupt()
    assert scouted(engine, base, [look], [screened(base)]) == [None]
    assert engine.rough_looks == looks
