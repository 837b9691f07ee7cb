"""What counts as right, and what many cases come to."""

from types import SimpleNamespace

import numpy as np
import pytest

from sim1.mismatch.summary import Shown
from sim1.proof.methods import methods_of
from sim1.proof.outcome import Found, Number, Outcome, is_right
from sim1.proof.page import by_strength, said
from sim1.proof.place import NOTHING_N_M2, place_auc
from sim1.proof.ranking import over_limit
from sim1.proof.totals import confusion_of, share_by_case, share_of, totals_of
from sim1.statistics import wilson_interval


def outcome(
    case, kind, concealed, verdict, named=(), low=0.9, heldout=(2.0, 0.5), oracle_mm=None, over=None, strength="medium"
):
    """A case in which 1.0 was found where 1.1 is true."""
    number = Number(value=1.0, low=low, high=1.2, unit="1", true=1.1)
    found = Found(
        first=named[0] if named else "wind",
        gains={"air_drag": 80.0},
        worths={"air_drag": 75.0},
        established=("air_drag",),
        steady=("air_drag",),
        least_misfit=tuple(named),
        effects={
            name: {"c": number if name in concealed else number.model_copy(update={"true": None})} for name in named
        },
        fabric={"poisson": number},
        misfit=(1.5, 1.0),
        misfit_alone=2.0,
        table=False,
        fit_mm=(1.0, 0.5),
        heldout_mm=heldout,
        place_auc=0.95 if concealed else None,
        over_limit={name: over for name in concealed if over is not None},
    )
    return Outcome(
        case=case,
        kind=kind,
        concealed={name: {"c": 1.1} for name in concealed},
        strength=strength,
        seed=1,
        places_given=True,
        verdict=verdict,
        named=tuple(named),
        right=is_right(kind, tuple(concealed), verdict, tuple(named)),
        error="it broke" if verdict == "failed" else None,
        seconds=100.0,
        code_sha256="c0de",
        code_changed=False,
        found=None if verdict == "failed" else found,
        oracle_mm=oracle_mm,
        oracle_s=None,
        baselines=None,
    )


CASES = [
    outcome("case_001", "null", [], "none"),
    outcome("case_002", "null", [], "named", ["air_drag"], heldout=(1.0, 1.3)),
    outcome("case_003", "single", ["air_drag"], "named", ["air_drag"]),
    outcome("case_004", "single", ["wind"], "ambiguous", ["wind"]),
    outcome("case_005", "single", ["wind"], "failed"),
    outcome("case_006", "outside", ["magnet"], "unknown"),
    outcome("case_007", "outside", ["magnet"], "named", ["gravity_tilt"]),
    outcome("case_008", "several", ["air_drag", "wind"], "named", ["air_drag", "wind"]),
    outcome("case_009", "several", ["adhesion", "wind"], "named", ["wind"], low=1.15),
    outcome("case_010", "several", ["adhesion", "wind"], "named", ["shrinkage", "wind"]),
]


def test_right_is_every_name_and_no_other_none_for_nothing_and_no_name_where_none_fits():
    assert [one.right for one in CASES] == [True, False, True, False, False, True, False, True, False, False]
    assert is_right("outside", ("magnet",), "ambiguous", ("wind", "air_drag"))
    assert not is_right("null", (), "unknown", ())


def test_shares_count_failures_as_wrong_and_carry_exact_intervals():
    totals = totals_of(CASES)
    assert (totals.named.count, totals.named.of, totals.failed) == (1, 3, 1)
    assert (totals.effects_ever_named.count, totals.effects_ever_named.of) == (1, 2)
    assert (totals.nulls_called_none.count, totals.nulls_called_none.of) == (1, 2)
    assert totals.false_names == {"air_drag": 1}
    assert (totals.outside_without_name.count, totals.outside_without_name.of) == (1, 2)
    assert (totals.several_named.count, totals.several_partly.count, totals.several_named.of) == (1, 2, 3)
    assert said(totals.effects_ever_named) == "1 of 2"  # which effects were drawn is no chance of the tool
    none_of_59 = share_of([False] * 59)
    assert none_of_59.low == 0.0
    assert none_of_59.high == pytest.approx(1 - 0.025 ** (1 / 59))  # Clopper and Pearson in closed form
    assert said(share_of([True] * 3 + [False] * 7)) == "3 of 10 (95 % interval 7 to 65 %)"
    assert said(share_of([])) == "none tried"


def test_coefficients_are_held_against_what_was_concealed_alone():
    totals = totals_of(CASES)
    assert (totals.effect_intervals.count, totals.effect_intervals.of) == (5, 6)  # two false names have no truth
    assert totals.effect_error == pytest.approx(1 - 1 / 1.1)
    assert (totals.fabric_intervals.count, totals.fabric_intervals.of) == (8, 9)
    assert (totals.worst_heldout.case, totals.worst_heldout.after_mm) == ("case_002", 1.3)
    assert (totals.heldout_worse, totals.heldout_lost) == (("case_002",), ())
    assert totals_of(CASES[:1]).worst_heldout is None
    assert totals_of([]).median_seconds is None


def test_coefficients_of_one_fit_count_as_few_trials_where_they_hold_or_fail_together():
    together = share_by_case([[True] * 5] * 9 + [[False] * 5] * 3)
    each = share_by_case([[True]] * 45 + [[False]] * 15)
    assert (together.count, together.of) == (each.count, each.of) == (45, 60)
    assert together.high - together.low > 1.8 * (each.high - each.low)
    assert (each.low, each.high) == pytest.approx(wilson_interval(45, 60))
    assert share_by_case([[], []]).of == 0


def test_a_model_without_a_simulation_is_a_harm_and_infinitely_far_off():
    lost = outcome("case_001", "single", ["wind"], "named", ["wind"], heldout=(2.0, None), oracle_mm=0.5)
    lost = lost.model_copy(update={"unseen_mm": (2.0, None), "oracle_unseen_mm": 0.5})
    fine = [outcome(f"case_00{k}", "single", ["wind"], "named", ["wind"], oracle_mm=0.5) for k in (2, 3)]
    fine = [one.model_copy(update={"unseen_mm": (2.0, 1.0), "oracle_unseen_mm": 0.5}) for one in fine]
    totals = totals_of([lost, *fine])
    assert totals.heldout_worse == totals.heldout_lost == totals.unseen_worse == totals.unseen_lost == ("case_001",)
    assert (totals.unseen_ratio, totals.unseen_cases) == (0.5, 3)
    assert (totals.unseen_gap_closed, totals.unseen_gaps) == (pytest.approx(1.0 / 1.5), 3)
    assert (totals.gap_closed, totals.gaps) == (pytest.approx(1.0), 3)
    alone = totals_of([lost])
    assert (alone.unseen_ratio, alone.unseen_cases, alone.gap_closed, alone.gaps) == (None, 1, None, 1)
    neither = lost.model_copy(update={"unseen_mm": (None, None)})
    assert totals_of([neither]).unseen_worse == ()  # nothing was added that did it


def test_what_was_gained_held_out_is_set_against_what_an_oracle_gains():
    half = outcome("case_001", "single", ["wind"], "named", ["wind"], heldout=(2.0, 1.25), oracle_mm=0.5)
    nothing_to_gain = outcome("case_002", "single", ["wind"], "named", ["wind"], heldout=(2.0, 1.9), oracle_mm=1.95)
    not_asked = outcome("case_003", "single", ["wind"], "named", ["wind"])
    assert half.gap_closed == pytest.approx(0.5)
    assert nothing_to_gain.gap_closed is None
    assert not_asked.gap_closed is None
    totals = totals_of([half, nothing_to_gain, not_asked])
    assert (totals.gap_closed, totals.gaps) == (pytest.approx(0.5), 1)


def limits(**least):
    """A summary's limits; names end in what is absent: `_0` or `_1`."""
    rows = [shown("it", name[:-2], absent=float(name[-1]), least=value) for name, value in least.items()]
    return SimpleNamespace(detectable=rows)


def shown(effect, coefficient, absent, least):
    return Shown(effect=effect, coefficient=coefficient, unit="1", absent=absent, least=least)


def test_strength_is_told_in_units_of_what_would_show():
    assert over_limit(limits(a_0=2.0), "it", {"a": -3.0}) == pytest.approx(1.5)
    assert over_limit(limits(a_0=2.0, b_0=1.0), "it", {"a": 6.0, "b": 4.0}) == pytest.approx(5.0)
    assert over_limit(limits(ratio_1=2.0), "it", {"ratio": 0.25}) == pytest.approx(2.0)
    assert over_limit(limits(a_0=None, b_0=1.0), "it", {"a": 6.0, "b": 0.5}) == pytest.approx(0.5)
    assert over_limit(limits(a_0=None), "it", {"a": 6.0}) == 0.0
    assert over_limit(limits(a_0=1.0), "it", {"another": 6.0}) is None
    assert over_limit(limits(a_0=1.0), "wind", {"a": 6.0}) is None


def test_strength_is_told_where_a_search_has_other_coefficients_than_a_model_file():
    softer = SimpleNamespace(detectable=[shown("grip_compliance", "compliance", absent=0.0, least=1 / 500)])
    assert over_limit(softer, "grip_compliance", {"stiffness": 200.0}) == pytest.approx(2.5)
    uneven = SimpleNamespace(detectable=[shown("anisotropic_friction", "ratio", absent=1.0, least=1.5)])
    assert over_limit(uneven, "anisotropic_friction", {"mu_x": 0.9, "mu_y": 0.4}) == pytest.approx(2.0)


def test_strong_and_weak_effects_are_counted_apart():
    strong = outcome("case_001", "single", ["wind"], "named", ["wind"], over=3.0)
    weak = [outcome(f"case_00{n}", "single", ["wind"], "none", over=0.9) for n in (2, 3)]
    unknown = outcome("case_004", "single", ["wind"], "none")
    totals = totals_of([strong, *weak, unknown])
    assert (totals.named_above_limit.count, totals.named_above_limit.of) == (1, 1)
    assert (totals.named_below_limit.count, totals.named_below_limit.of) == (0, 2)


def test_what_the_laboratory_could_not_make_as_strong_as_asked_is_counted_apart():
    full = {"reached": {"wind": 0.8, "adhesion": 1.3}}
    one, both = ("case_001", "single", ["wind"]), ("case_004", "several", ["adhesion", "wind"])
    told = [
        outcome(*one, "named", ["wind"]).model_copy(update=full),
        outcome(*one, "none").model_copy(update={"reached": {"wind": 0.6}}),
        outcome(*one, "none"),  # of which nobody says it
        outcome(*both, "named", ["adhesion", "wind"]).model_copy(update=full),
        outcome(*both, "named", ["wind"]).model_copy(update={"reached": {"wind": 1.0, "adhesion": 0.4}}),
        outcome(*both, "named", ["wind"]).model_copy(update=full),
    ]
    totals = totals_of(told)
    assert (totals.named.of, totals.named_as_asked.count, totals.named_as_asked.of) == (3, 1, 1)
    assert (totals.several_named.of, totals.several_as_asked.count, totals.several_as_asked.of) == (3, 1, 2)


WEAK = [
    outcome("case_011", "single", ["wind"], "none", strength="weak", oracle_mm=0.5),
    outcome("case_012", "single", ["wind"], "unknown", strength="weak"),
    outcome("case_013", "single", ["wind"], "ambiguous", ["wind"], strength="weak"),
    outcome("case_014", "single", ["wind"], "named", ["wind"], strength="weak"),
    outcome("case_015", "single", ["wind"], "named", ["air_drag"], strength="weak"),
    outcome("case_016", "single", ["wind"], "failed", strength="weak"),
    outcome("case_017", "single", ["wind"], "named", ["wind"], strength="strong"),
]


def test_single_effects_are_told_by_strength_and_weak_ones_stand_in_no_headline():
    totals = totals_of([*CASES, *WEAK])
    assert (totals.named.count, totals.named.of) == (2, 4)  # one of three medium ones, one strong
    assert (totals.first_ranked.of, totals.effects_ever_named.count, totals.gaps) == (4, 2, 0)
    assert {name: (of.named.count, of.named.of) for name, of in totals.by_strength.items()} == {
        "weak": (1, 6),
        "medium": (1, 3),
        "strong": (1, 1),
    }
    weak = totals.by_strength["weak"]
    assert (weak.called_none, weak.called_unknown, weak.wrong_name, weak.failed) == (1, 2, 1, 1)
    assert weak.first_ranked.count == 4  # the stand-in ranks wind first where it names nothing else
    assert weak.named.high == pytest.approx(share_of([True] + [False] * 5).high)
    assert totals_of([]).by_strength["strong"].named.of == 0


def test_where_a_weak_effect_acts_is_no_figure_of_place():
    nowhere = [one.model_copy(update={"found": one.found.model_copy(update={"place_auc": 0.5})}) for one in WEAK[:3]]
    assert totals_of([*CASES, *nowhere]).place_auc == totals_of(CASES).place_auc == pytest.approx(0.95)


def test_of_a_weak_effect_silence_is_no_fault_and_a_wrong_name_is():
    assert [one.wrong for one in WEAK] == [False, False, False, False, True, True, False]
    assert [one.right for one in WEAK] == [False, False, False, True, False, False, True]
    assert outcome("case_001", "single", ["wind"], "none").wrong
    assert outcome("case_001", "outside", ["magnet"], "none", strength="weak").wrong


def test_a_terminal_tells_the_strengths_that_were_tried():
    lines = by_strength(totals_of([*CASES, *WEAK[:6]]))
    assert [line.split(":")[0].strip() for line in lines] == ["one effect, weak", "one effect, medium"]
    assert "named right 1 of 6 (95 % interval 0 to 64 %)" in lines[0]
    assert "called none 1, unknown or ambiguous 2, a wrong name 1, failed 1" in lines[0]


def test_methods_are_compared_without_weak_effects():
    rows = {row.name: row for row in methods_of([*CASES, *WEAK])}
    assert (rows["the diagnosis"].singles.count, rows["the diagnosis"].singles.of) == (2, 4)
    assert rows["the diagnosis"].heldout_cases == rows["parameters alone"].heldout_cases == 6


def test_an_effect_outside_the_table_that_was_called_ambiguous_counts_as_right_and_is_shown_apart():
    strange = [
        outcome(f"case_{k}", "outside", ("magnet",), *said)
        for k, said in enumerate((("unknown",), ("ambiguous", ("wind",))))
    ]
    totals, matrix = totals_of(strange), confusion_of(strange)
    assert (totals.outside_without_name.count, totals.outside_ambiguous.count, totals.outside_ambiguous.of) == (2, 1, 2)
    assert dict(zip(matrix.columns, matrix.counts[0], strict=True)) == {
        "none": 0,
        "unknown": 1,
        "ambiguous": 1,
        "failed": 0,
    }


def test_the_confusion_matrix_says_what_was_called_what():
    matrix = confusion_of(CASES)
    assert matrix.rows == ("none", "air_drag", "wind", "adhesion + wind", "air_drag + wind", "magnet")
    assert matrix.columns[:4] == ("none", "unknown", "ambiguous", "failed")
    assert sum(map(sum, matrix.counts)) == len(CASES)
    cell = {
        (row, column): n for row, line in zip(matrix.rows, matrix.counts) for column, n in zip(matrix.columns, line)
    }
    assert (
        cell["none", "air_drag"]
        == cell["wind", "ambiguous"]
        == cell["wind", "failed"]
        == cell["magnet", "unknown"]
        == 1
    )
    assert cell["magnet", "gravity_tilt"] == cell["adhesion + wind", "shrinkage + wind"] == 1
    assert cell["wind", "wind"] == 0


def test_a_force_found_where_it_was_concealed_scores_one_and_elsewhere_none():
    concealed = np.zeros((50, 10))
    concealed[20:30, :2] = 1.0
    time = np.linspace(0, 2, 50)
    answers = {"a/stamps_s": time, "a/missing_n_m2": concealed}

    def scored(share):
        return place_auc({"a": (time, np.repeat((1e-3 * share)[..., None], 3, axis=2))}, answers)

    assert scored(concealed) == pytest.approx(1.0)
    assert scored(1 - concealed) == pytest.approx(0.0)
    answers["a/missing_n_m2"] = np.ones((50, 10))
    assert scored(concealed) is None  # what acts everywhere has no place
    answers["a/missing_n_m2"] = 0.9 * NOTHING_N_M2 * concealed
    assert scored(concealed) is None  # rounding is no force
