"""From which strength an effect would be named, of fingerprints that are given."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sim1.cloth.effects import EFFECTS
from sim1.mismatch.detectable import FAR, detectable
from sim1.mismatch.screen import Candidate
from sim1.mismatch.search import Term
from sim1.mismatch.thresholds import THRESHOLDS


def shown(name, *information, variants=1, thresholds=THRESHOLDS):
    term = Term.of(EFFECTS[name], {})
    candidate = Candidate(term=term, gain=0.0, start=np.zeros(0), variants=variants, information=information)
    return detectable((candidate,), thresholds)


def evidence(z, information):
    """Mean log evidence of an effect of strength z over its absence, Laplace's, prior of one: z^2 P / 2 - log(1 + P) / 2."""
    return 0.5 * z**2 * information - 0.5 * math.log1p(information)


@pytest.mark.parametrize("variants", [1, 16])
def test_at_the_limit_the_mean_evidence_is_what_a_name_and_its_search_cost(variants):
    [row] = shown("added_mass", 400.0, variants=variants)
    mass = EFFECTS["added_mass"].coefficients[0]
    price = THRESHOLDS.named + THRESHOLDS.per_term + math.log(variants)
    assert evidence(mass.z(row.least), 400.0) == pytest.approx(price)
    assert (row.effect, row.coefficient, row.unit, row.absent) == ("added_mass", "mass", "kg/m^2", 0.0)


def test_recordings_that_tell_four_times_as_much_show_half_the_strength():
    near, far = (shown("added_mass", p)[0].least for p in (4e4, 1e4))
    assert far / near == pytest.approx(2.0, rel=0.1)  # but for what more evidence costs


def test_a_name_that_is_asked_more_for_shows_later():
    dear = replace(THRESHOLDS, named=4 * THRESHOLDS.named)
    assert shown("added_mass", 400.0, thresholds=dear)[0].least > 1.5 * shown("added_mass", 400.0)[0].least


def test_what_would_have_to_be_beyond_three_typical_strengths_is_not_foretold():
    just = 2.0 * (THRESHOLDS.named + THRESHOLDS.per_term + 3.0) / FAR**2
    assert shown("added_mass", 1.5 * just)[0].least is not None
    assert shown("added_mass", 0.5 * just)[0].least is None
    assert shown("added_mass", 0.0)[0].least is None


def test_a_strength_that_can_only_fall_is_told_the_other_way():
    """A ratio's limit is above 1 unless that is out of bounds."""
    assert shown("anisotropic_bending", 400.0)[0].least > 1.0


def test_each_strength_of_an_effect_has_its_own_limit_and_shapes_have_none():
    rows = shown("rest_curvature", 400.0, 100.0)
    assert [row.coefficient for row in rows] == ["kappa_u", "kappa_v"]
    assert rows[0].least < rows[1].least
    assert [row.coefficient for row in shown("stiff_region", 400.0)] == ["factor"]
