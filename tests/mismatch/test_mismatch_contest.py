"""Models against each other: what is sought from where, what is tried beside what, on models whose answer is known."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle, filmed
from small_pool import pool_of
from straight_engine import TRUE, Straight, two_unknowns

from sim1.cloth.effects import EFFECTS
from sim1.mismatch import contest
from sim1.mismatch.afar import Found
from sim1.mismatch.decide import gain_of
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import fit
from sim1.mismatch.models import Model, Tried, joined, judged, leading, widened, without
from sim1.mismatch.screen import Candidate
from sim1.mismatch.search import Term, baseline
from sim1.mismatch.thresholds import THRESHOLDS


@pytest.fixture(autouse=True)
def _nothing_afar(monkeypatch):
    monkeypatch.setattr(contest, "from_afar", lambda *asked: Found())


@pytest.fixture
def unknowns():
    return two_unknowns()


def test_a_leader_is_searched_to_the_end_and_who_is_far_behind_is_left(unknowns, monkeypatch):
    engine, tempers = Straight(bent=0.3), {"only": 1.0}
    monkeypatch.setattr(contest, "temper_of", lambda *_: tempers)
    half = fit(engine, unknowns, np.zeros(2), ("only",), temper=tempers, most=1, settle=False)
    behind = fit(engine, unknowns, np.array([9.0, 9.0]), ("only",), temper=tempers, most=0)
    hopeless = replace(behind, slopes={"only": 0.0 * behind.slopes["only"]})
    pool = [
        Model(terms=(), fit=hopeless, variants=1),
        Model(terms=("air_drag",), fit=half, variants=1),
        Model(terms=("wind",), fit=hopeless, variants=1),
    ]
    found = contest.to_the_end(engine, contest.Contest(pool=pool, temper=tempers), ("only",), THRESHOLDS)
    null, leader, other = found.pool
    assert not half.converged
    assert leader.fit.converged
    assert leader.fit.cost < half.cost - 1.0
    assert [model.fit.z.tolist() for model in (null, other)] == [[9.0, 9.0]] * 2


def test_effects_are_sought_again_from_a_baseline_that_was_freed(unknowns, monkeypatch):
    engine, tempers, starts = Straight(), {"only": 1.0}, []
    stuck = fit(engine, unknowns, np.array([30.0, 30.0]), ("only",), temper=tempers, most=0)
    arrived = fit(engine, unknowns, np.zeros(2), ("only",), temper=tempers)

    def looked_from(engine, base, *rest):
        starts.append(base.cost)
        return Tried(models=(Model(terms=("air_drag",), fit=arrived, variants=1),))

    def seen_from_afar(engine, base, *rest):
        return Found(models=(Model(terms=("clock_offset",), fit=arrived, variants=1),) if base is stuck else ())

    monkeypatch.setattr(contest, "extended", looked_from)
    monkeypatch.setattr(contest, "from_afar", seen_from_afar)
    found = contest.with_one_effect(engine, stuck, ("only",), THRESHOLDS, lambda share, what: None)
    assert starts == [pytest.approx(stuck.cost), pytest.approx(arrived.cost, abs=0.1)]
    assert contest.null_of(found.pool).score == pytest.approx(found.pool[1].score, abs=0.1)
    assert [model.terms for model in found.pool] == [(), ("air_drag",), ("clock_offset",)]  # the first round's too


@pytest.mark.parametrize("moves", [0, 1, 2, 3])
def test_effects_are_sought_from_every_baseline_that_was_freed_up_to_the_third(unknowns, monkeypatch, moves):
    engine, tempers, starts = Straight(), {"only": 1.0}, []
    places = [
        fit(engine, unknowns, np.full(2, far), ("only",), temper=tempers, most=0) for far in (30.0, 20.0, 10.0, 5.0)
    ]

    def looked_from(engine, base, *rest):
        starts.append(base.cost)
        return Tried()

    def freed(engine, pool, *rest):
        arrived = places[min(len(starts), moves)]
        return [Model(terms=(), fit=arrived, variants=1)]

    monkeypatch.setattr(contest, "extended", looked_from)
    monkeypatch.setattr(contest, "simplified", freed)
    contest.with_one_effect(engine, places[0], ("only",), THRESHOLDS, lambda share, what: None)
    assert starts == [place.cost for place in places[: moves + 1]][: contest.SEARCHES]


def test_a_second_effect_is_sought_beside_the_rivals_of_the_best_too(unknowns, monkeypatch):
    """Else one of two that explain it alike wins because the other was not taken further."""
    engine, tempers = Straight(), {"only": 1.0}
    stuck = fit(engine, unknowns, np.array([30.0, 30.0]), ("only",), temper=tempers, most=0)
    near = fit(engine, unknowns, TRUE + 0.01, ("only",), temper=tempers, most=0)
    arrived = fit(engine, unknowns, TRUE, ("only",), temper=tempers, most=0)
    names = {id(near): "clock_offset", id(arrived): "actuator_lag"}
    singles = [
        Model(terms=(name,), fit=one, variants=1) for one, name in ((near, "clock_offset"), (arrived, "actuator_lag"))
    ]
    pool = [Model(terms=(), fit=stuck, variants=1), *singles, Model(terms=("adhesion",), fit=stuck, variants=1)]

    def with_drag(engine, base, *rest, **how):
        gain = gain_of(pool, next(one for one in pool if one.fit is base), THRESHOLDS)
        assert how["least"] == contest.hint_of(gain, THRESHOLDS) < 0.01 * gain
        pair = tuple(sorted((names[id(base)], "air_drag")))
        return Tried(models=(Model(terms=pair, fit=base, variants=1),))

    def together(engine, model, other, temper, names):
        joint.append((*model.terms, *other.terms))
        return Model(terms=tuple(sorted(joint[-1])), fit=stuck, variants=1)

    joint = []
    monkeypatch.setattr(contest, "joined", together)
    monkeypatch.setattr(contest, "extended", with_drag)
    monkeypatch.setattr(contest, "_tempered", lambda engine, found, names, thresholds: found)
    known = contest.Contest(pool=pool, temper=tempers, alone=tuple(singles))
    found = contest.with_a_second(engine, known, ("only",), THRESHOLDS, lambda share, what: None)
    tried = {model.terms for model in found.pool if len(model.terms) == 2}
    both = ("actuator_lag", "clock_offset")  # that gain alone, tried together once
    assert tried == {("air_drag", "clock_offset"), ("actuator_lag", "air_drag"), both}  # and none beside the hopeless
    assert joint == [("actuator_lag", "clock_offset")]
    assert found.unfollowed == ()
    monkeypatch.setattr(contest, "joined", lambda *asked: None)  # no simulation with both finds its way
    found = contest.with_a_second(engine, known, ("only",), THRESHOLDS, lambda share, what: None)
    assert found.unfollowed == (both,)
    assert both not in {model.terms for model in found.pool}


def test_what_was_sought_from_afar_and_followed_by_no_simulation_is_told_unless_it_was_fitted_otherwise(
    unknowns, monkeypatch
):
    engine, tempers = Straight(), {"only": 1.0}
    stuck = fit(engine, unknowns, np.zeros(2), ("only",), temper=tempers)
    singles = (Model(terms=("adhesion",), fit=stuck, variants=1),)
    told = Found(unfollowed=(("adhesion",), ("clock_offset",), ("clock_offset",)))
    monkeypatch.setattr(contest, "from_afar", lambda *asked: told)
    monkeypatch.setattr(contest, "extended", lambda *asked: Tried(models=singles))
    found = contest.with_one_effect(engine, stuck, ("only",), THRESHOLDS, lambda share, what: None)
    assert found.unfollowed == (("clock_offset",),)


@pytest.mark.parametrize("gain", [0.0, 500.0, 3000.0, 40000.0])
def test_no_second_effect_is_fitted_that_could_be_no_name_and_none_that_could_is_left_out(gain):
    hint = contest.hint_of(gain, THRESHOLDS)
    could = THRESHOLDS.doubtful * max(THRESHOLDS.named, THRESHOLDS.second_share * gain)
    assert hint == contest.HINT < 0.75 * THRESHOLDS.named or hint == pytest.approx(
        0.75 * could
    )  # slopes foretell to a quarter
    assert hint >= 0.7 * could


def test_what_gains_by_itself_is_tried_beside_the_best_though_no_slope_promises_anything_of_it(unknowns, monkeypatch):
    """Beside a crease, places of grips imitate a grip that yields: alone each gains 220 and 265 nats, both 826."""
    engine, tempers = Straight(), {"only": 1.0}
    far = fit(engine, unknowns, np.array([30.0, 30.0]), ("only",), temper=tempers, most=0)
    arrived = fit(engine, unknowns, TRUE, ("only",), temper=tempers, most=0)
    half = fit(engine, unknowns, TRUE + 1.0, ("only",), temper=tempers, most=0)
    best = Model(terms=("wind",), fit=arrived, variants=1)
    others = [Model(terms=(name,), fit=half, variants=1) for name in ("adhesion", "grip_slip", "air_drag")]
    pool = [Model(terms=(), fit=far, variants=1), best, others[0]]  # the others are no finalists
    again = Model(terms=("adhesion",), fit=half, variants=7)
    tried = []

    def together(engine, model, other, temper, names):
        tried.append((model.terms, other.terms))
        return Model(terms=tuple(sorted((*model.terms, *other.terms))), fit=arrived, variants=1)

    monkeypatch.setattr(contest, "joined", together)
    found = contest.Contest(pool=[*pool[:2], again], temper=tempers, alone=(best, *others))
    there, told = {("adhesion", "wind")}, []
    made = contest.with_others(engine, found, best, there, ("only",), told.append)
    assert told == ["grip_slip"]
    # Adhesion was tried, and wind holds the drag of still air.
    assert tried == [(("wind",), ("grip_slip",))]
    assert {terms: model.terms for terms, model in made.items()} == {("grip_slip", "wind"): ("grip_slip", "wind")}
    assert contest.with_others(engine, found, *made.values(), there, ("only",), told.append) == {}
    tried.clear()
    # No wind beside air drag either, and two at most.
    contest.with_others(engine, found, others[2], set(), ("only",), told.append)
    assert tried == [(("air_drag",), ("adhesion",)), (("air_drag",), ("grip_slip",))]
    tried.clear()
    more = replace(found, alone=(best, *others, replace(best, terms=("shrinkage",))))
    assert len(contest.with_others(engine, more, best, set(), ("only",), told.append)) == contest.OTHERS == 2
    engine.patience.interrupt()
    assert contest.with_others(engine, more, best, set(), ("only",), told.append) == {}


def test_two_effects_that_were_fitted_alone_are_fitted_together_from_where_each_arrived():
    tilted = (0.0, 0.3, -9.805)
    bundle = filmed(empty_bundle(motions=2, duration_s=1.2), air_normal=1.3, gravity_m_s2=tilted)
    with Engine(bundle) as engine:
        names, plain = engine.names, baseline(bundle)
        temper = dict.fromkeys(names, 3.0)
        drag, tilt = (
            judged(fit(engine, one, np.zeros(one.count), names, temper=temper, most=2), temper)
            for one in (plain.with_terms(Term.of(EFFECTS[name])) for name in ("air_drag", "gravity_tilt"))
        )
        both = joined(engine, drag, tilt, temper, names)
        assert both.terms == ("air_drag", "gravity_tilt")
        assert both.variants == drag.variants * tilt.variants
        assert both.score < min(drag.score, tilt.score) - 100.0
        start = np.concatenate([drag.fit.z, tilt.fit.z[plain.count :]])
        at_start = fit(engine, both.fit.unknowns, start, names, temper=temper, most=0)
        assert both.fit.cost <= at_start.cost


def test_of_the_best_pair_each_effect_is_fitted_alone_too_and_its_evidence_counted_by_what_it_leaves(
    unknowns, monkeypatch
):
    """Else nobody asks what the first adds to the second."""
    engine, tempers, fewer = Straight(), {"only": 1.0}, {"only": 2.0}
    far = fit(engine, unknowns, np.array([30.0, 30.0]), ("only",), temper=tempers, most=0)
    near = fit(engine, unknowns, TRUE + 0.1, ("only",), temper=tempers, most=0)
    arrived = fit(engine, unknowns, TRUE, ("only",), temper=tempers, most=0)
    pair = Model(terms=("adhesion", "wind"), fit=arrived, variants=1)
    pool = [Model(terms=(), fit=far, variants=1), Model(terms=("wind",), fit=near, variants=1)]
    asked = []

    def part(engine, model, place, names):
        asked.append(model.terms)
        return Model(terms=(pair.terms[1 - place],), fit=far, variants=1)

    monkeypatch.setattr(contest, "extended", lambda *given, **how: Tried(models=(pair,)))
    monkeypatch.setattr(contest, "without", part)
    monkeypatch.setattr(contest, "temper_of", lambda engine, residuals, names: fewer)
    monkeypatch.setattr(contest, "judged", lambda fit, temper, variants=1: Model(terms=(), fit=fit, variants=variants))
    monkeypatch.setattr(contest, "simplified", lambda engine, pool, thresholds, names: pool)
    known = [model.terms for model in contest.with_parts(engine, [*pool, pair], THRESHOLDS, ("only",))]
    assert sorted(known) == [(), ("adhesion",), pair.terms, ("wind",)]
    assert set(asked) == {pair.terms}
    kept = {model.terms: model.fit for model in contest.with_parts(engine, [*pool, pair], THRESHOLDS, ("only",))}
    assert kept["wind",] is near  # the part fits worse
    stuck = replace(pool[1], fit=fit(engine, unknowns, np.array([40.0, 40.0]), ("only",), temper=tempers, most=0))
    kept = {model.terms: model.fit for model in contest.with_parts(engine, [stuck, pair], THRESHOLDS, ("only",))}
    assert kept["wind",] is far  # a search that got stuck before is not what the part is judged by
    found = contest.with_a_second(
        engine, contest.Contest(pool=pool, temper=tempers), ("only",), THRESHOLDS, lambda share, what: None
    )
    assert found.temper == fewer


@pytest.mark.parametrize(
    ("screened", "further"),
    [
        ((200.0, 190.0, 20.0, 10.0), ["air_drag", "wind"]),  # the look at wind stopped on the way: it says little
        ((200.0, 90.0, 20.0, 10.0), ["air_drag"]),
        ((200.0, 190.0, 150.0, 140.0), ["air_drag", "wind", "adhesion"]),  # three at most
    ],
)
def test_who_was_as_promising_on_screen_is_taken_further_however_little_a_first_look_found(unknowns, screened, further):
    gains = {("air_drag",): 400.0, ("wind",): 120.0, ("adhesion",): 40.0, ("grip_slip",): 30.0}
    _, *models = pool_of(replace(unknowns, nominal=()), gains)
    tried = [
        Candidate(term=Term.of(EFFECTS[one.terms[0]]), gain=gain, start=np.zeros(0), variants=1)
        for one, gain in zip(models, screened, strict=True)
    ]
    assert [models[k].terms[0] for k in leading(models, tried)] == further


def test_an_effect_is_taken_out_with_its_own_coefficients_and_the_others_stay():
    bundle = filmed(empty_bundle(motions=2, duration_s=1.2), air_normal=1.3)
    with Engine(bundle) as engine:
        names, plain = engine.names, baseline(bundle)
        temper = dict.fromkeys(names, 3.0)
        both = plain.with_terms(Term.of(EFFECTS["air_drag"]), Term.of(EFFECTS["clock_offset"]))
        start = np.zeros(both.count)
        start[both.part(0)], start[both.part(1)] = 0.5, 0.3
        model = judged(fit(engine, both, start, names, temper=temper, most=0), temper)
        alone = [without(engine, model, place, names) for place in (0, 1)]
        assert [one.terms for one in alone] == [("clock_offset",), ("air_drag",)]
        for one, place in zip(alone, (0, 1), strict=True):
            assert one.fit.unknowns.count == both.count - len(both.terms[place].coefficients)
        assert alone[1].fit.cost < alone[0].fit.cost - 100.0  # drag is what was concealed


def test_a_weak_stream_is_found_from_the_drag_of_still_air():
    """Streams of 0.6 m/s, from which wind is sought, are far from one of 0.1 m/s."""
    bundle = filmed(empty_bundle(motions=2), air_normal=1.3, wind_m_s=(0.02, 0.12, 0.0))
    with Engine(bundle) as engine:
        names, plain = engine.names, baseline(bundle)
        temper = dict.fromkeys(names, 3.0)
        still = plain.with_terms(Term.of(EFFECTS["air_drag"]))
        drag = judged(fit(engine, still, np.zeros(still.count), names, temper=temper), temper)
        [wind] = widened(engine, drag, temper, names)
    assert wind.terms == ("wind",)
    assert drag.score - wind.score > 20.0
    found = wind.fit.unknowns.values(0, wind.fit.z)
    assert found["vy"] == pytest.approx(0.12, abs=0.03)
    assert widened(None, wind, temper, names) == []
