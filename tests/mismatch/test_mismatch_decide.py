"""A verdict says no more than the evidence: thresholds, simplest model within reach, rivals, excess that nothing explains."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from small_pool import fitted, pool_of, verdict

from sim1.mismatch.decide import decide, gain_of, there
from sim1.mismatch.excess import mean_square
from sim1.mismatch.findings import admitted, probabilities
from sim1.mismatch.thresholds import THRESHOLDS

WORTH_ALONE = replace(THRESHOLDS, gain=np.inf)  # nothing stands out by what it gains alone


pytestmark = pytest.mark.usefixtures("counted_once")


def test_a_gain_below_the_threshold_is_nothing(unknowns):
    assert verdict(unknowns, {("air_drag",): THRESHOLDS.named - 1}, thresholds=WORTH_ALONE) == ("none", ())
    assert verdict(unknowns, {("air_drag",): THRESHOLDS.named + 1}) == ("named", ("air_drag",))


def test_a_name_that_fits_worse_than_what_counts_errors_often_is_ambiguous(unknowns, monkeypatch):
    """Case 24 of the campaign: anisotropy gains 214 nats and counts errors 14 times, stiffening threads 70 and 3 times."""
    pool = pool_of(unknowns, {("anisotropic_stretch",): 214.0, ("strain_stiffening",): 70.0})
    monkeypatch.setattr("sim1.mismatch.decide.overcounted", lambda fit, base: 14.0 if fit is pool[1].fit else 3.0)
    found = decide(pool, replace(WORTH_ALONE, named=20.0))
    assert (found.verdict, found.chosen.terms) == ("ambiguous", ("strain_stiffening",))
    assert [one.terms for one in found.rivals] == [("anisotropic_stretch",)]


def test_an_excess_over_noise_counts_by_itself(unknowns):
    """A motion that a thread hinders is like nothing that is known."""
    gains = {("heavy_region",): 0.5 * THRESHOLDS.named}
    assert verdict(unknowns, gains, {(): 1.1 * THRESHOLDS.misfit}) == ("unknown", ())
    assert verdict(unknowns, gains, {(): 0.9 * THRESHOLDS.misfit}) == ("none", ())


def test_what_pushes_in_one_recording_alone_is_missing_too(unknowns):
    """A magnet beside which the sheet swings once."""
    quiet = {f"quiet_{k}": 0.8 for k in range(4)}
    for pushed, said in ((0.9 * THRESHOLDS.misfit_alone, "none"), (1.1 * THRESHOLDS.misfit_alone, "unknown")):
        null, model = pool_of(unknowns, {("heavy_region",): 0.0})
        null = replace(null, fit=fitted(unknowns, pushed=pushed, **quiet))
        better = replace(null.fit, temper=dict.fromkeys(null.fit.names, 1.03))
        pool = [null, replace(model, fit=better)]
        assert mean_square(null.fit) < THRESHOLDS.misfit
        assert gain_of(pool, pool[1], THRESHOLDS) < THRESHOLDS.gain
        assert decide(pool, THRESHOLDS).verdict == said


def test_a_model_that_leaves_most_of_the_excess_is_unknown(unknowns):
    misfits = {(): 9.0, ("air_drag",): 6.0}
    assert verdict(unknowns, {("air_drag",): 500.0}, misfits) == ("unknown", ())
    misfits[("air_drag",)] = 3.0
    assert verdict(unknowns, {("air_drag",): 500.0}, misfits) == ("named", ("air_drag",))


def test_a_small_excess_that_a_model_leaves_is_unknown_too(unknowns):
    """A push that is in no table makes several effects gain a little each, and explains itself to none."""
    misfits = {(): 1.2, ("gravity_tilt",): 1.17}
    assert verdict(unknowns, {("gravity_tilt",): 120.0}, misfits) == ("unknown", ())
    misfits[("gravity_tilt",)] = 1.08
    assert verdict(unknowns, {("gravity_tilt",): 120.0}, misfits) == ("named", ("gravity_tilt",))


def test_a_model_after_which_something_is_missing_as_much_as_before_is_asked_to_explain_more(unknowns):
    """A stream of air explains 0.44 of what a jet leaves, and leaves a mean square of 1.8; a heavy place 0.4 of its own, and leaves 1.1."""
    share = 0.5 * (THRESHOLDS.explained + THRESHOLDS.explained_whole)
    for before, said in ((1.0 + 0.9 * (THRESHOLDS.misfit - 1.0) / (1.0 - share), "named"), (2.5, "unknown")):
        misfits = {(): before, ("wind",): before - share * (before - 1.0)}
        assert misfits[("wind",)] > THRESHOLDS.left
        assert verdict(unknowns, {("wind",): 900.0}, misfits)[0] == said


def test_what_was_measured_without_a_model_is_named_however_much_else_is_missing(unknowns):
    """Markers a third of a second late, over a net that creeps: the delay is known, and most of what is left has no name."""
    pair = ("clock_offset", "wind")
    gains = {pair: 950.0, ("clock_offset",): 850.0, ("actuator_lag",): 700.0, ("wind",): 900.0}
    misfits = {(): 9.0, pair: 6.2, ("clock_offset",): 6.4, ("actuator_lag",): 6.6, ("wind",): 6.5}
    pool = pool_of(unknowns, gains, misfits)
    assert decide(pool, THRESHOLDS).verdict == "unknown"
    found = decide(pool, THRESHOLDS, frozenset({"clock_offset", "actuator_lag"}))
    assert (found.verdict, found.chosen.terms) == ("named", ("clock_offset",))
    little = pool_of(unknowns, {pair: 950.0, ("clock_offset",): 0.5 * THRESHOLDS.named}, misfits)
    assert decide(little, THRESHOLDS, frozenset({"clock_offset"})).verdict == "unknown"


def test_two_that_explain_it_alike_are_ambiguous_and_neither_is_hidden(unknowns):
    pool = pool_of(unknowns, {("clock_offset",): 300.0, ("actuator_lag",): 300.0 - 0.5 * THRESHOLDS.margin})
    found = decide(pool, THRESHOLDS)
    assert found.verdict == "ambiguous"
    assert [model.terms for model in found.rivals] == [("actuator_lag",)]


def test_two_that_gain_a_little_each_are_no_name_together(unknowns):
    pair = ("anisotropic_bending", "anisotropic_stretch")
    gains = {pair: 1.3 * THRESHOLDS.named, pair[:1]: 0.5 * THRESHOLDS.named, pair[1:]: 0.55 * THRESHOLDS.named}
    found = decide(pool_of(unknowns, gains), WORTH_ALONE)
    assert (found.verdict, found.chosen.terms) == ("none", ())


@pytest.fixture
def now_more_now_less(monkeypatch):
    """What a model gains counts an error 30 times, and differs from second to second."""
    monkeypatch.setattr("sim1.mismatch.decide.overcounted", lambda fit, base: 30.0)
    monkeypatch.setattr("sim1.mismatch.decide.unsteadiness", lambda fit, base: 1.1 * THRESHOLDS.unsteady)


def test_what_gains_more_than_nothing_missing_ever_does_is_no_nothing(unknowns, now_more_now_less):
    """A jet of air makes a stream gain, now more of it, now less: no name, and something is there."""
    assert verdict(unknowns, {("wind",): 0.9 * THRESHOLDS.gain}) == ("none", ())
    assert verdict(unknowns, {("wind",): 1.1 * THRESHOLDS.gain}) == ("unknown", ())


def test_what_the_baseline_imitates_all_the_way_is_told_by_priors_and_need_not_be_steady(unknowns, now_more_now_less):
    """Cloth shrunk by 1.3 %: the baseline takes its lengths for that much shorter than the ruler said, and moves alike."""
    null, model = pool_of(unknowns, {("shrinkage",): 5.0})
    for nats, said in ((0.9 * THRESHOLDS.named, "none"), (1.1 * THRESHOLDS.named, "named")):
        z = np.array([np.sqrt(2.0 * nats)])
        pool = [
            replace(one, fit=replace(one.fit, z=z * far, slopes={"only": np.zeros((10, 1))}))
            for one, far in ((null, 1.0), (model, 0.0))
        ]
        assert decide(pool, THRESHOLDS).verdict == said


def test_what_gains_much_and_is_worth_little_is_something_missing_and_no_name(unknowns, monkeypatch):
    """A piece that dries makes a heavy place gain 535 nats, about alike from second to second, that count one error again and again."""
    monkeypatch.setattr("sim1.mismatch.decide.overcounted", lambda fit, base: 100.0)
    monkeypatch.setattr("sim1.mismatch.decide.unsteadiness", lambda fit, base: 0.9 * THRESHOLDS.unsteady)
    heavy = ("heavy_region",)
    assert verdict(unknowns, {heavy: 0.9 * THRESHOLDS.gain}) == ("none", ())
    assert verdict(unknowns, {heavy: 535.0}) == ("unknown", ())
    assert probabilities(tuple(pool_of(unknowns, {heavy: 535.0})), "unknown", THRESHOLDS)["heavy_region"] < 0.01


def test_an_effect_whose_strength_could_be_nothing_is_no_name_and_nothing_is_missing_for_it(unknowns, monkeypatch):
    """A magnet makes a tilt gain, and each recording asks for another tilt; so do errors of the simulator."""
    pool = pool_of(unknowns, {("gravity_tilt",): 1.7 * THRESHOLDS.named, ("wind",): 0.8 * THRESHOLDS.named})
    monkeypatch.setattr("sim1.mismatch.decide.there", lambda pool_, model, thresholds: model is not pool[1])
    for least, said in ((0.7, "unknown"), (0.9, "none"), (1.6, "none")):  # the wind's gain counts, the tilt's does not
        found = decide(pool, replace(THRESHOLDS, gain=least * THRESHOLDS.named))
        assert (found.verdict, found.chosen.terms) == (said, ())
    pool = pool_of(unknowns, {("gravity_tilt",): 1.7 * THRESHOLDS.named, ("wind",): 1.1 * THRESHOLDS.named})
    monkeypatch.setattr("sim1.mismatch.decide.there", lambda pool_, model, thresholds: model is not pool[1])
    found = decide(pool, THRESHOLDS)
    assert (found.verdict, found.chosen.terms) == ("ambiguous", ("wind",))  # what is no name fits better


def test_evidence_that_counts_one_error_many_times_makes_no_name(unknowns, monkeypatch):
    """Nothing is missing, the mesh bends a little wrong in one recording, and an anisotropy follows it there."""
    pool = pool_of(unknowns, {("anisotropic_stretch",): 2.0 * THRESHOLDS.named})
    monkeypatch.setattr("sim1.mismatch.decide.overcounted", lambda fit, base: 1.9)
    assert decide(pool, THRESHOLDS).verdict == "named"
    monkeypatch.setattr("sim1.mismatch.decide.overcounted", lambda fit, base: 2.1)
    found = decide(pool, WORTH_ALONE)
    assert (found.verdict, found.chosen.terms) == ("none", ())


def test_an_effect_that_is_asked_for_now_more_now_less_follows_something_else(unknowns, monkeypatch):
    pool = pool_of(unknowns, {("wind",): 3000.0, ("clock_offset",): 2900.0})
    monkeypatch.setattr("sim1.mismatch.decide.unsteadiness", lambda fit, base: 1.1 * THRESHOLDS.unsteady)
    monkeypatch.setattr("sim1.mismatch.decide.overcounted", lambda fit, base: 0.9 * THRESHOLDS.steady)
    assert decide(pool, THRESHOLDS).chosen.terms == ("wind",)
    monkeypatch.setattr("sim1.mismatch.decide.overcounted", lambda fit, base: 1.1 * THRESHOLDS.steady)
    assert decide(pool, THRESHOLDS).verdict == "unknown"
    assert decide(pool, THRESHOLDS, frozenset({"clock_offset"})).chosen.terms == ("clock_offset",)
    monkeypatch.setattr("sim1.mismatch.decide.unsteadiness", lambda fit, base: 0.9 * THRESHOLDS.unsteady)
    assert decide(pool, THRESHOLDS).chosen.terms == ("wind",)


def test_what_is_simpler_and_does_not_stand_takes_no_name_away_unless_it_is_a_part(unknowns, monkeypatch):
    """Still air's drag imitates a stream almost as well, now more of it, now less."""
    pool = pool_of(unknowns, {("wind",): 330.0, ("air_drag",): 300.0})
    monkeypatch.setattr("sim1.mismatch.decide.overcounted", lambda fit, base: 20.0 if fit is pool[2].fit else 1.0)
    assert decide(pool, WORTH_ALONE).chosen.terms == ("wind",)
    pool = pool_of(unknowns, {("adhesion", "wind"): 330.0, ("wind",): 300.0})
    assert decide(pool, WORTH_ALONE).verdict == "none"


def test_a_rival_that_fits_better_keeps_its_probability_and_what_rules_refused_has_none(unknowns):
    pool = pool_of(unknowns, {("anisotropic_stretch",): 214.0, ("strain_stiffening",): 70.0, ("wind",): 60.0})
    better, chosen, worse = pool[1:]
    found = SimpleNamespace(verdict="ambiguous", chosen=chosen, rivals=(better,), models=tuple(pool), heard=())
    assert [one.terms for one in admitted(found, THRESHOLDS)] == [(), better.terms, chosen.terms, worse.terms]
    found.verdict, found.rivals = "named", ()
    assert [one.terms for one in admitted(found, THRESHOLDS)] == [(), chosen.terms, worse.terms]


def test_where_motion_held_out_made_the_name_those_that_it_was_asked_about_are_judged_with_it(unknowns):
    """By fits alone the rival is ahead of what motion held out has named."""
    stretch, stiff = ("anisotropic_stretch",), ("strain_stiffening",)
    pool, heard = pool_of(unknowns, {stretch: 60.0, stiff: 50.0}), pool_of(unknowns, {stretch: 100.0, stiff: 300.0})
    found = SimpleNamespace(verdict="named", chosen=pool[2], rivals=(), models=tuple(pool), heard=tuple(heard))
    standing = admitted(found, THRESHOLDS)
    assert [one.terms for one in standing] == [(), stretch, stiff]
    assert all(any(one is other for other in heard) for one in standing)


def test_even_odds_are_where_a_name_begins_and_the_unknown_is_as_probable_as_all_names(unknowns):
    pool = tuple(pool_of(unknowns, {("air_drag",): THRESHOLDS.named}))
    assert probabilities(pool, "named", THRESHOLDS)["air_drag"] == pytest.approx(0.5)
    pool = tuple(pool_of(unknowns, {("air_drag",): THRESHOLDS.named + 100, ("wind",): THRESHOLDS.named + 100}))
    assert sum(probabilities(pool, "named", THRESHOLDS).values()) == pytest.approx(1.0, abs=1e-6)
    assert sum(probabilities(pool, "unknown", THRESHOLDS).values()) == pytest.approx(0.5, abs=1e-6)
    assert probabilities(tuple(pool_of(unknowns, {("wind",): 0.0})), "none", THRESHOLDS)["wind"] < 0.01


def test_each_effect_is_tested_along_the_way_from_the_model_without_it_and_by_its_slopes_where_there_is_none(
    unknowns, monkeypatch
):
    two = tuple(SimpleNamespace(effect=SimpleNamespace(name=name)) for name in ("air_drag", "wind"))
    pool = pool_of(unknowns, {("air_drag",): 50.0, ("air_drag", "wind"): 80.0})
    drag, pair = pool[1], pool[2]
    pair = replace(pair, fit=replace(pair.fit, unknowns=SimpleNamespace(terms=two)))
    asked = []
    monkeypatch.setattr("sim1.mismatch.decide.established", lambda fit, place, level: asked.append(place) or True)
    monkeypatch.setattr("sim1.mismatch.decide.established_along", lambda fit, base, level: asked.append(base) or True)
    assert there([pool[0], drag, pair], pair, THRESHOLDS)
    assert asked[0] == 0  # nobody fitted wind alone
    assert asked[1] is drag.fit
    monkeypatch.setattr("sim1.mismatch.decide.established_along", lambda fit, base, level: False)
    assert not there([pool[0], drag, pair], pair, THRESHOLDS)
