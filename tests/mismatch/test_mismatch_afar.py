"""Effects that no slope at nothing tells are sought from values far off, with the fabric relieved of what they would do."""

from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
import pytest
from straight_engine import Straight, two_unknowns

from sim1.cloth.effects.adhesion import Adhesion
from sim1.cloth.effects.clock_offset import ClockOffset
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch import afar
from sim1.mismatch.fit import fit
from sim1.mismatch.models import judged
from sim1.mismatch.search import Term, Unknowns

FRICTION = Coefficient(name="friction", unit="1", scale=0.2, centre=0.3, low=0.0)
LOAD_PA = 0.2 * 9.81
TRUE = {"friction": 0.3, "pressure": 2.5}
TEMPER = {"only": 1.0}


@dataclass
class Clinging(Straight):
    """What slides shows friction times load; what is lifted shows the pressure by itself, and little of a small one."""

    lifted: float = 4.0  # how much lifting shows
    finest: int = 1
    finer: int = 1

    def residuals(self, unknowns, z, names):
        friction = unknowns.nominal[0].value(z[0])
        pressure = unknowns.world(z).adhesion_pa
        drag = friction * (LOAD_PA + pressure) - TRUE["friction"] * (LOAD_PA + TRUE["pressure"])
        lift = (pressure / TRUE["pressure"]) ** 3 - 1.0
        noise = 0.3 * np.random.default_rng(1).standard_normal(300)
        return {"only": np.concatenate([np.full(280, 60.0 * drag), np.full(20, self.lifted * lift)]) + noise}

    def slopes(self, unknowns, z, names, first=0):
        self.looks += 1
        here, step = self.residuals(unknowns, z, names), 1e-4
        columns = [
            (self.residuals(unknowns, z + step * one, names)["only"] - here["only"]) / step for one in np.eye(len(z))
        ]
        return here, {"only": np.stack(columns, axis=1)[:, first:]}

    @contextmanager
    def aside(self):
        yield


@pytest.fixture
def unknowns():
    """Friction alone, of a sheet on a table."""
    made = two_unknowns()
    return Unknowns(base=replace(made.base, table_z_m=0.0), nominal=(FRICTION,))


@pytest.fixture(autouse=True)
def _what_is_possible(monkeypatch):
    monkeypatch.setattr(afar, "site_of", lambda engine, world: None)
    monkeypatch.setattr(afar, "possible", lambda site, terms: [Adhesion, ClockOffset])
    monkeypatch.setattr(
        afar, "calibrate", lambda engine, known, z, names, told: fit(engine, known, z, names, temper=TEMPER)
    )


def not_converged(*asked, **how):
    raise NotConverged("recording only: twins find no next state at 1 s")


def baseline_of(engine, unknowns):
    return fit(engine, unknowns, np.zeros(1), ("only",), temper=TEMPER)


def test_cloth_that_clings_is_told_from_friction_though_slopes_at_nothing_tell_nothing(unknowns):
    engine = Clinging()
    base = baseline_of(engine, unknowns)
    assert unknowns.world(base.z).friction > 2.0 * TRUE["friction"]  # it does the work of both
    both = unknowns.with_terms(Term.of(Adhesion))
    near = np.append(base.z, [0.0, 0.0])
    stuck = fit(engine, both, near, ("only",), temper=TEMPER)
    assert both.values(0, stuck.z)["pressure"] < 0.5

    (found,) = afar.from_afar(engine, base, TEMPER, ("only",), variants=3).models
    assert found.terms == ("adhesion",)
    assert found.fit.unknowns.values(0, found.fit.z)["pressure"] == pytest.approx(TRUE["pressure"], rel=0.05)
    assert found.fit.unknowns.world(found.fit.z).friction == pytest.approx(TRUE["friction"], rel=0.1)
    assert found.fit.cost < stuck.cost - 50.0
    assert found.variants == 3 * len(Adhesion.afar)


def test_a_fabric_is_relieved_of_what_the_effect_would_do_and_of_nothing_else(unknowns):
    known = replace(unknowns, nominal=(replace(FRICTION, name="stretch_n_m", centre=300.0, scale=10.0), FRICTION))
    base = replace(baseline_of(Clinging(), unknowns), unknowns=known, z=np.array([1.5, 2.0]))
    z = afar.relieved(base, Term.of(Adhesion), {"pressure": 3.0 * LOAD_PA, "reach": 1e-3})
    assert z[0] == 1.5
    assert FRICTION.value(z[1]) == pytest.approx(FRICTION.value(2.0) / 4.0)
    assert afar.relieved(base, Term.of(ClockOffset), {"offset": 0.2}) == pytest.approx(base.z)


def test_where_nothing_is_gained_from_afar_nothing_is_searched(unknowns, monkeypatch):
    engine = Clinging(lifted=0.0)
    base = baseline_of(engine, unknowns)
    monkeypatch.setattr(afar, "fit", lambda *asked: pytest.fail("searched from a start that gains nothing"))
    assert afar.from_afar(engine, base, TEMPER, ("only",)) == afar.Found()


@pytest.mark.parametrize(("left", "asked"), [(1.0, {"adhesion": 1}), (2.5, {"adhesion": 1, "clock_offset": 2})])
def test_what_hides_in_no_fabric_is_sought_where_a_baseline_leaves_much(unknowns, monkeypatch, left, asked):
    """The latter from the baseline as it was before any fit, too."""
    engine, sought = Clinging(), {}

    def none_of(engine, starts, *rest):
        term = starts[0][0].terms[0].effect
        sought[term.name] = len(starts) / len(term.afar)

    base = baseline_of(engine, unknowns)
    monkeypatch.setattr(afar, "cheapest", none_of)
    monkeypatch.setattr(afar, "mean_square", lambda base: left)
    assert afar.from_afar(engine, base, TEMPER, ("only",)) == afar.Found()
    assert sought == asked


def test_a_search_that_no_simulation_follows_is_told(unknowns, monkeypatch):
    engine = Clinging()
    base = baseline_of(engine, unknowns)
    monkeypatch.setattr(afar, "fit", not_converged)
    assert afar.from_afar(engine, base, TEMPER, ("only",)) == afar.Found(unfollowed=(("adhesion",),))


def test_a_search_that_was_stopped_looks_at_nothing_more(unknowns, monkeypatch):
    engine = Clinging()
    base = baseline_of(engine, unknowns)
    engine.patience.interrupt()
    monkeypatch.setattr(afar, "site_of", lambda engine, world: pytest.fail("meshes may be half refined"))
    assert afar.from_afar(engine, base, TEMPER, ("only",)) == afar.Found()


class Folded(Clinging):
    """A high friction costs the same whatever the pressure is: slopes there lead nowhere."""

    def residuals(self, unknowns, z, names):
        found = super().residuals(unknowns, z, names)
        high = unknowns.nominal[0].value(z[0]) > 0.5
        return {name: np.full_like(one, 1.8) if high else one for name, one in found.items()}


def held_up(unknowns):
    engine, both = Folded(), unknowns.with_terms(Term.of(Adhesion))
    z = np.array([FRICTION.z(0.7), 2.0, 0.0])
    return engine, judged(fit(engine, both, z, ("only",), temper=TEMPER), TEMPER, variants=2)


def test_a_model_that_leaves_much_is_fitted_once_more_from_a_fabric_that_was_not_bent(unknowns):
    engine, stuck = held_up(unknowns)
    (found,) = afar.unbent(engine, stuck, TEMPER, ("only",))
    assert found.terms == stuck.terms
    assert found.variants == stuck.variants
    assert found.fit.cost < stuck.fit.cost - 100.0
    assert found.fit.unknowns.world(found.fit.z).friction == pytest.approx(TRUE["friction"], rel=0.1)


@pytest.mark.parametrize("why", ["leaves little", "is the baseline", "time is over"])
def test_it_is_left_as_it_is_where_there_is_no_need_or_no_time(unknowns, monkeypatch, why):
    engine, stuck = held_up(unknowns)
    if why == "leaves little":
        stuck = replace(stuck, fit=replace(stuck.fit, residuals={"only": np.full(300, 0.9)}))
    elif why == "is the baseline":
        stuck = replace(stuck, terms=())
    else:
        engine.patience.interrupt()
    monkeypatch.setattr(afar, "calibrate", lambda *asked: pytest.fail(why))
    assert afar.unbent(engine, stuck, TEMPER, ("only",)) == ()


def test_a_model_stays_where_no_simulation_follows_from_an_unbent_fabric(unknowns, monkeypatch):
    engine, stuck = held_up(unknowns)
    monkeypatch.setattr(afar, "calibrate", not_converged)
    assert afar.unbent(engine, stuck, TEMPER, ("only",)) == ()
