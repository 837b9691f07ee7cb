"""What the tables of many diagnoses count."""

from benchmarks.diagnosis.tables import tables
from benchmarks.diagnosis.trial import Number, Trial


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
        effects={name: {"c": number} for name in named},
        baseline={"poisson": number},
        heldout_mm=(2.0, 0.5),
        misfit=(1.5, 1.0),
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
            trial("air_drag+wind_1", ["air_drag", "wind"], "named", ["air_drag", "wind"]),
        ]
    )
    assert "1 of 2 cases with nothing missing were called `none`" in text
    assert "2 of 3 cases with something missing were named right and alone" in text
    assert "| none_2 | 121 | given | **named** |" in text
    assert "| 80 | wind 60 | 2.00 -> 0.50 | 1.50 -> 1.00 | 100 | 95 % |" in text


def test_a_value_outside_its_interval_is_counted_so():
    inside = tables([trial("air_drag_1", ["air_drag"], "named", ["air_drag"])])
    assert "Parameters of the fabric: 1 of 1 inside" in inside
    assert "median error 9 %" in inside
    assert "0 of 1 inside" in tables([trial("none_1", [], "none", [], low=1.15)])
