"""The diagnosis beside simpler methods: what each row of the table counts."""

import pytest
from test_proof_score import outcome

from sim1.mismatch.summary import Ranked
from sim1.proof.files import Baselines, Generic, Sparse
from sim1.proof.methods import commonest, methods_of
from sim1.proof.ranking import least_misfit


def with_baselines(one, named, sindy_mm=1.0, residual_mm=1.5):
    said = Baselines(
        case=one.case,
        sindy=Sparse(named=named, heldout_mm=sindy_mm, seconds=10.0),
        residual=Generic(heldout_mm=residual_mm, seconds=20.0),
    )
    return one.model_copy(update={"baselines": said})


CASES = [
    with_baselines(outcome("case_001", "null", [], "none", heldout=(2.0, 2.0)), ("wind",)),
    with_baselines(outcome("case_002", "null", [], "none", heldout=(2.0, 2.0)), ()),
    with_baselines(outcome("case_003", "single", ["wind"], "named", ["wind"], oracle_mm=0.4), ("wind",)),
    with_baselines(outcome("case_004", "single", ["adhesion"], "none", heldout=(2.0, 2.0)), ("adhesion", "wind")),
    with_baselines(outcome("case_005", "outside", ["magnet"], "unknown", heldout=(2.0, 2.0)), ()),
    outcome("case_006", "several", ["adhesion", "wind"], "named", ["adhesion", "wind"]),
]


def rows(cases):
    return {row.name.split(" (")[0]: row for row in methods_of(cases)}


def counted(share):
    return share.count, share.of


def test_each_method_is_held_to_the_same_answers_and_counts_only_where_it_was_asked():
    table = rows(CASES)
    diagnosis, sindy = table["the diagnosis"], table["sparse regression on forces"]
    assert [counted(s) for s in (diagnosis.singles, diagnosis.nulls, diagnosis.outside, diagnosis.several)] == [
        (1, 2), (2, 2), (1, 1), (1, 1),
    ]  # fmt: skip
    assert [counted(s) for s in (sindy.singles, sindy.nulls, sindy.outside, sindy.several)] == [
        (1, 2), (1, 2), (0, 1), (0, 0),
    ]  # fmt: skip
    assert (diagnosis.cases, sindy.cases) == (6, 5)
    assert (diagnosis.seconds, sindy.seconds) == (100.0, 10.0)


def test_what_is_commonest_is_told_by_the_cases_that_count():
    weak = [outcome(f"case_01{n}", "single", ["air_drag"], "none", strength="weak") for n in range(4)]
    assert commonest([*CASES, *weak]) == commonest(CASES)


def test_errors_held_out_are_told_in_units_of_parameters_alone_where_the_table_has_a_name():
    table = rows(CASES)
    assert (table["parameters alone"].heldout, table["parameters alone"].heldout_cases) == (1.0, 3)
    assert table["the diagnosis"].heldout == pytest.approx(0.25)  # of 0.25, 1 and 0.25
    assert table["sparse regression on forces"].heldout == pytest.approx(0.5)
    assert table["a residual of 18 numbers, without a name"].heldout == pytest.approx(0.75)
    assert table["the oracle, which is told the effects"].cases == 0


def test_gaps_are_closed_where_an_oracle_was_asked_and_gained():
    asked = [one.model_copy(update={"oracle_s": 5.0 if one.oracle_mm else None}) for one in CASES]
    table = rows(asked)
    assert table["the oracle, which is told the effects"].gap_closed == pytest.approx(1.0)
    assert table["sparse regression on forces"].gap_closed == pytest.approx((2.0 - 1.0) / (2.0 - 0.4))
    assert table["parameters alone"].gap_closed == 0.0
    assert table["the oracle, which is told the effects"].gaps == 1


def test_a_model_that_no_simulation_follows_is_counted_and_infinitely_far_off():
    lost = outcome("case_003", "single", ["wind"], "named", ["wind"], heldout=(2.0, None), oracle_mm=0.4)
    diagnosis = rows([lost])["the diagnosis"]
    assert (diagnosis.heldout, diagnosis.heldout_cases, diagnosis.lost) == (None, 1, 1)
    assert (diagnosis.gap_closed, diagnosis.gaps) == (None, 1)
    several = rows([lost, *CASES[2:3], *CASES[5:]])["the diagnosis"]
    assert (several.heldout, several.heldout_cases, several.lost) == (pytest.approx(0.25), 3, 1)
    sindy = rows([with_baselines(lost, ("wind",), sindy_mm=None, residual_mm=None)])
    assert [
        sindy[name].lost for name in ("sparse regression on forces", "a residual of 18 numbers, without a name")
    ] == [1, 1]


def test_what_names_nothing_has_no_share_of_names():
    for label in ("a residual of 18 numbers, without a name", "parameters alone"):
        assert rows(CASES)[label].singles is None


def test_the_commonest_answer_and_the_commonest_name_are_counted():
    assert commonest(CASES) == (("none",), ("adhesion",))  # wind as often: the first by alphabet
    assert commonest(CASES[2:3]) == (("wind",), ("wind",))
    assert commonest([]) == (("none",), ("none",))
    table = rows(CASES)
    assert counted(table["always the commonest answer"].nulls) == (2, 2)
    assert counted(table["always the commonest answer"].singles) == (0, 2)
    assert counted(table["always the commonest name"].singles) == (1, 2)
    assert counted(table["always the commonest name"].nulls) == (0, 2)


def test_a_regression_that_could_not_be_made_is_wrong_everywhere():
    table = rows([with_baselines(one, None, None) for one in CASES[:4]])
    sindy = table["sparse regression on forces"]
    assert (counted(sindy.nulls), counted(sindy.singles), sindy.heldout) == ((0, 2), (0, 2), None)


def test_the_least_misfit_names_whatever_fits_best_without_a_price():
    class Ranking:
        ranking = (
            Ranked(name="wind", gain=90.0, worth=80.0, unsteadiness=0.1, established=True, steady=True, misfit=1.1),
            Ranked(
                name="wind with adhesion",
                gain=89.0,
                worth=60.0,
                unsteadiness=0.1,
                established=True,
                steady=True,
                misfit=1.05,
            ),
            Ranked(
                name="the baseline", gain=0.0, worth=0.0, unsteadiness=0.1, established=True, steady=True, misfit=2.0
            ),
        )

    assert least_misfit(Ranking) == ("adhesion", "wind")
    Ranking.ranking = Ranking.ranking[2:]
    assert least_misfit(Ranking) == ()
