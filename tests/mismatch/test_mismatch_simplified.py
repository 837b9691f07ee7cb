"""Simpler models are fitted from where a richer one arrived, so that a search that got stuck looks like no physics."""

from dataclasses import replace

import numpy as np
import pytest
from straight_engine import Straight, two_unknowns

from sim1.mismatch.fit import fit
from sim1.mismatch.models import Model
from sim1.mismatch.simplified import MATTERS, STUCK, simplified
from sim1.mismatch.thresholds import THRESHOLDS


@pytest.fixture
def unknowns():
    return two_unknowns()


def test_a_baseline_that_got_stuck_is_fitted_from_where_a_richer_model_arrived(unknowns):
    engine, tempers = Straight(), {"only": 1.0}
    stuck = fit(engine, unknowns, np.array([3.0, 3.0]), ("only",), temper=tempers, most=0)
    arrived = fit(engine, unknowns, np.zeros(2), ("only",), temper=tempers)
    pool = [Model(terms=(), fit=stuck, variants=1), Model(terms=("air_drag",), fit=arrived, variants=1)]
    null, _ = simplified(engine, pool, THRESHOLDS, ("only",))
    assert null.terms == ()
    assert null.score == pytest.approx(pool[1].score, abs=0.1)


@pytest.mark.parametrize("far_behind", [False, True])
def test_what_a_baseline_could_still_gain_is_sought_only_where_it_matters(far_behind, unknowns):
    engine, tempers = Straight(), {"only": 1.0}
    arrived = fit(engine, unknowns, np.zeros(2), ("only",), temper=tempers)
    near = fit(engine, unknowns, arrived.z + 0.01, ("only",), temper=tempers, most=0)
    richer = replace(arrived, residuals={"only": 0.0 * arrived.residuals["only"]}) if far_behind else arrived
    pool = [Model(terms=(), fit=near, variants=1), Model(terms=("air_drag",), fit=richer, variants=1)]
    lacks = near.cost - arrived.cost
    assert (near.cost - richer.cost) * MATTERS > lacks if far_behind else lacks > STUCK
    null, _ = simplified(engine, pool, THRESHOLDS, ("only",))
    assert (null is pool[0]) == far_behind
