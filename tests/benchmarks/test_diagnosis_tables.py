"""What the tables of many diagnoses count."""

import numpy as np
import pytest

from benchmarks.diagnosis.tables import tables
from benchmarks.diagnosis.trial import Number, Trial, place_auc
from sim1.mismatch.assimilate import Forces


def trial(case: str, concealed: list[str], verdict: str, named: list[str], low: float = 0.9) -> Trial:
    """A diagnosis that found 1.0 where 1.1 is true."""
    number = Number(value=1.0, low=low, high=1.2, true=1.1)
    return Trial(
        case=case,
        concealed=concealed,
        vertices=121,
        places_given=True,
        verdict=verdict,
        named=named,
        gains={"air_drag": 80.0, "wind": 60.0, "air_drag + wind": 90.0},
        misfits={"": 1.5, "air_drag": 1.0},
        costs={"": {"swing": (90.0, 1.5)}, "air_drag": {"swing": (10.0, 1.0)}},
        effects={name: {"c": number} for name in named},
        baseline={"poisson": number},
        fit_mm=(1.0, 0.5),
        heldout_mm=(2.0, 0.5),
        misfit=(1.5, 1.0),
        place_auc=0.95 if concealed else None,
        seconds=100.0,
        simulating_s=95.0,
    )


def test_right_and_wrong_verdicts_are_counted_apart():
    text = tables(
        [
            trial("none_1", [], "none", []),
            trial("none_2", [], "named", ["air_drag"]),
            trial("air_drag_1", ["air_drag"], "named", ["air_drag"]),
            trial("wind_1", ["wind"], "ambiguous", ["wind"]),
            trial("magnet_1", ["magnet"], "unknown", []),
            trial("magnet_2", ["magnet"], "named", ["gravity_tilt"]),
            trial("air_drag+wind_1", ["air_drag", "wind"], "named", ["air_drag", "wind"]),
        ]
    )
    assert "1 of 2 cases with nothing missing were called `none`" in text
    assert (
        "3 of 5 cases with something missing were named right and alone, or called unknown where no name fits" in text
    )
    assert "| none_2 | 121 | given | **named** |" in text
    assert "| 80 | wind 60 | 2.00 -> 0.50 | 1.50 -> 1.00 | 0.95 | 100 | 95 % |" in text


def test_a_force_found_where_it_was_concealed_scores_one_and_elsewhere_none():
    concealed = np.zeros((50, 10))
    concealed[20:30, :2] = 1.0
    answers = {"a/stamps_s": np.linspace(0, 2, 50), "a/missing_n_m2": concealed}

    def scored(share):
        force = np.repeat((1e-3 * share)[..., None], 3, axis=2)
        time = np.linspace(0, 2, 50)
        return place_auc((Forces(name="a", time_s=time, force_n=force, floor_n=0.0, velocity_m_s=0 * force),), answers)

    assert scored(concealed) == pytest.approx(1.0)
    assert scored(1 - concealed) == pytest.approx(0.0)
    answers["a/missing_n_m2"] = np.ones((50, 10))
    assert scored(concealed) is None  # what acts everywhere has no place


def test_a_value_outside_its_interval_is_counted_so():
    inside = tables([trial("air_drag_1", ["air_drag"], "named", ["air_drag"])])
    assert "Parameters of the fabric: 1 of 1 inside" in inside
    assert "median error 9 %" in inside
    assert "0 of 1 inside" in tables([trial("none_1", [], "none", [], low=1.15)])
