"""What a diagnosis says with one part left out: rules on pools and shortlists that are given, and every variant on a small film."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from small_bundle import empty_bundle, filmed
from small_pool import fitted, pool_of

from benchmarks.diagnosis import left_out
from benchmarks.diagnosis.left_out import COLUMNS, fit_error_alone, no_veto, screening_alone, with_parts_left_out
from sim1.cloth.effects import EFFECTS
from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.screen import Candidate
from sim1.mismatch.search import Term, baseline
from sim1.mismatch.thresholds import THRESHOLDS

DRAG, BOTH = ("air_drag",), ("air_drag", "heavy_region")
ENOUGH, LITTLE = 2.0 * THRESHOLDS.named, 0.5 * THRESHOLDS.named


@pytest.fixture(scope="module")
def unknowns():
    """A model without any coefficient."""
    return replace(baseline(empty_bundle(motions=2)), nominal=())


def whole_of(pool, verdict="unknown", chosen=0, lost=()):
    """As much of a diagnosis as is read of it once its models are there; `chosen`: place in the pool."""
    return SimpleNamespace(
        models=tuple(pool),
        baseline=pool[0],
        chosen=pool[chosen],
        measured=frozenset(),
        verdict=verdict,
        stopped=False,
        lost=lost,
    )


def test_by_fit_error_alone_the_least_misfit_is_named_whatever_it_costs_or_gains(unknowns):
    pool = pool_of(unknowns, {DRAG: ENOUGH, BOTH: LITTLE}, {(): 2.0, DRAG: 1.2, BOTH: 1.19})
    assert fit_error_alone(whole_of(pool)) == ("named", BOTH)


def test_by_fit_error_alone_nothing_is_missing_only_where_all_fit_about_as_badly(unknowns):
    pool = pool_of(unknowns, {DRAG: ENOUGH}, {(): 1.0, DRAG: 0.96})
    assert fit_error_alone(whole_of(pool)) == ("none", ())


def test_without_a_veto_a_name_that_motion_held_out_took_back_stays(unknowns, monkeypatch):
    monkeypatch.setattr("sim1.mismatch.decide.overcounted", lambda fit, base: 1.0)
    pool = pool_of(unknowns, {DRAG: ENOUGH}, {(): 2.0, DRAG: 1.0})
    assert no_veto(whole_of(pool, verdict="unknown")) == ("named", DRAG)


def test_without_a_veto_what_was_never_held_against_motion_stays_as_it_was_said(unknowns, monkeypatch):
    """Nothing gains, and an effect that no simulation followed keeps the whole diagnosis from `none`."""
    monkeypatch.setattr("sim1.mismatch.decide.overcounted", lambda fit, base: 1.0)
    lost = (SimpleNamespace(gain=ENOUGH),)
    assert no_veto(whole_of(pool_of(unknowns, {DRAG: LITTLE}), lost=lost)) == ("unknown", ())


def test_without_motion_held_out_what_it_alone_made_a_name_is_none(unknowns, monkeypatch):
    monkeypatch.setattr("sim1.mismatch.decide.overcounted", lambda fit, base: 1.0)
    assert no_veto(whole_of(pool_of(unknowns, {DRAG: LITTLE}), verdict="named", chosen=1)) == ("none", ())


@pytest.mark.parametrize(
    ("beside_the_baseline", "beside_the_first", "misfit", "said"),
    [
        ({"air_drag": LITTLE}, {}, 1.0, ("none", ())),
        ({"air_drag": LITTLE}, {}, 2.0, ("unknown", ())),
        ({"air_drag": ENOUGH, "wind": ENOUGH - 1.0}, {"heavy_region": LITTLE}, 2.0, ("named", DRAG)),
        ({"heavy_region": ENOUGH}, {"air_drag": ENOUGH}, 2.0, ("named", BOTH)),
        # A strong effect leaves a part of what it gains to whatever imitates what its formula gets wrong.
        ({"air_drag": 100.0 * ENOUGH}, {"heavy_region": ENOUGH}, 2.0, ("named", DRAG)),
    ],
)
def test_by_screening_alone_what_is_promised_is_named_and_a_misfit_without_a_promise_is_unknown(
    unknowns, monkeypatch, beside_the_baseline, beside_the_first, misfit, said
):
    lists = iter([beside_the_baseline, beside_the_first])
    monkeypatch.setattr(left_out, "Engine", lambda bundle: nullcontext())
    monkeypatch.setattr(left_out, "_measured_at", lambda engine, known: known)
    monkeypatch.setattr(left_out, "_with_its_slopes", lambda engine, base, first: base)
    monkeypatch.setattr(left_out, "_shortlist", lambda engine, base: [promise(*row) for row in next(lists).items()])
    whole = SimpleNamespace(baseline=SimpleNamespace(fit=fitted(unknowns, only=misfit)))
    assert screening_alone(None, whole) == said


def promise(name, gain):
    return Candidate(term=Term.of(EFFECTS[name]), gain=gain, start=np.zeros(0), variants=1)


def test_a_variant_that_no_simulation_follows_has_failed_and_the_others_say_what_they_say(unknowns, monkeypatch):
    def lost(bundle, *given):
        raise NotConverged("recording only: no rest")

    pool = pool_of(unknowns, {DRAG: ENOUGH}, {(): 2.0, DRAG: 1.0})
    whole = whole_of(pool)
    whole.chosen = pool[1]
    monkeypatch.setattr("sim1.mismatch.decide.overcounted", lambda fit, base: 1.0)
    monkeypatch.setattr(left_out, "diagnose", lambda bundle: whole)
    for name in ("nothing_measured", "not_orthogonal", "screening_alone"):
        monkeypatch.setattr(left_out, name, lost)
    found = with_parts_left_out(None)
    assert tuple(found) == COLUMNS
    assert {label for label, (verdict, _, _) in found.items() if verdict == "failed"} == {
        "nothing measured", "not orthogonal", "screening alone",
    }  # fmt: skip


@pytest.mark.slow
def test_every_variant_gives_a_verdict_of_a_film_and_the_whole_names_the_concealed_drag():
    found = with_parts_left_out(filmed(empty_bundle(), air_normal=3.0))
    assert tuple(found) == COLUMNS
    assert {verdict for verdict, _, _ in found.values()} <= {"none", "named", "ambiguous", "unknown"}
    for label in ("whole", "no veto", "screening alone"):
        assert found[label][:2] == ("named", DRAG)
    assert "air_drag" in found["fit error alone"][1]
    assert found["no veto"][2] + found["fit error alone"][2] < 0.05 * found["whole"][2]  # they simulate nothing
