"""Motions that no diagnosis was given: predictions beside what the laboratory knows, and what many cases come to."""

import numpy as np
import pandas as pd
import pytest
from test_proof_score import outcome

from sim1.proof.totals import totals_of
from sim1.proof.unseen import off_m, off_mm
from sim1.stage import BadInput

TIME_S = np.arange(5) / 60
TRUTH_M = np.random.default_rng(0).normal(size=(5, 3, 3))
ANSWERS = {"u/truth_s": TIME_S, "u/truth_m": TRUTH_M, "v/truth_s": TIME_S, "v/truth_m": -TRUTH_M}

MOTIONS = ("u", "v")


def foretold(off=0.0, frames=5, names=("u", "v")):
    """A table that is off by so much in every coordinate, its rows in no order."""
    rows = [
        (name, TIME_S[frame], marker, *(sign * TRUTH_M[frame, marker] + off))
        for name, sign in (("u", 1), ("v", -1))
        for frame in range(frames)
        for marker in range(3)
        if name in names
    ]
    return pd.DataFrame(rows, columns=["recording", "time_s", "marker", "x_m", "y_m", "z_m"]).sample(frac=1, random_state=1)  # fmt: skip


def test_the_error_is_per_coordinate_whatever_the_order_of_rows():
    assert off_m(foretold(), ANSWERS, MOTIONS) == 0.0
    assert off_m(foretold(off=0.002), ANSWERS, MOTIONS) == pytest.approx(0.002)


def test_what_the_answers_tell_of_motions_that_the_diagnosis_was_given_is_left_out():
    others = {"given/truth_s": TIME_S, "given/truth_m": TRUTH_M + 1.0}
    assert off_m(foretold(), ANSWERS | others, MOTIONS) == 0.0


def test_a_motion_of_which_the_answers_tell_nothing_is_named():
    with pytest.raises(KeyError, match="v/truth_s"):
        off_m(foretold(), {key: course for key, course in ANSWERS.items() if key[0] == "u"}, MOTIONS)


def test_predictions_that_end_before_the_film_does_are_held_to_what_they_tell():
    assert off_m(foretold(off=0.002, frames=4), ANSWERS, MOTIONS) == pytest.approx(0.002)


def test_predictions_that_leave_out_the_end_are_refused():
    time_s = np.arange(61) / 60
    answers = {"u/truth_s": time_s, "u/truth_m": np.zeros((61, 1, 3))}
    rows = [("u", time, 0, 0.0, 0.0, 0.0) for time in time_s[:31]]
    with pytest.raises(ValueError, match=r"u: foretold until 0.50 s, filmed until 1.00 s"):
        off_m(pd.DataFrame(rows, columns=foretold().columns), answers, ["u"])


def test_what_was_not_foretold_is_not_known(tmp_path):
    assert off_mm(tmp_path / "model.parquet", ANSWERS, MOTIONS) is None


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (foretold().assign(recording="w"), r"foretold are \['w'\], filmed were \['u', 'v'\]"),
        (foretold(names=("u",)), r"foretold are \['u'\], filmed were \['u', 'v'\]"),
        (foretold().assign(time_s=lambda rows: 2 * rows["time_s"]), r"u: 15 rows, 5 instants and 3 markers"),
        (foretold().query("marker < 2"), r"u: 10 rows, 5 instants and 2 markers, the answers have \(5, 3\)"),
        (foretold().iloc[1:], r"rows, 5 instants"),
        (foretold().drop(columns="y_m"), "y_m"),
        (foretold().iloc[:0], "foretold are none"),
        (foretold().assign(x_m="far"), "unsupported operand|did not contain a loop|ufunc"),
        (
            foretold()
            .sort_values(["recording", "time_s", "marker"])
            .assign(z_m=lambda rows: np.where(np.arange(len(rows)) == 4, np.nan, rows["z_m"])),
            r"u: z_m of the marker in place 1 at 0.017 s is nan, in the answers .*bring the file that",
        ),
    ],
)
def test_predictions_of_something_else_are_refused_with_their_file(tmp_path, table, said):
    path = tmp_path / "model.parquet"
    table.to_parquet(path)
    with pytest.raises(BadInput, match=rf"model.parquet: no predictions .*{said}"):
        off_mm(path, ANSWERS, MOTIONS)


def test_a_damaged_file_is_named(tmp_path):
    path = tmp_path / "model.parquet"
    path.write_bytes(b"PAR1 and no more")
    with pytest.raises(BadInput, match=r"model.parquet: no predictions"):
        off_mm(path, ANSWERS, MOTIONS)


def test_what_cases_come_to_counts_those_with_names_in_the_table_and_tells_every_rise_beyond_two_per_cent():
    def of(case, kind, concealed, unseen_mm, oracle_mm=None):
        one = outcome(case, kind, concealed, "named", concealed)
        return one.model_copy(update={"unseen_mm": unseen_mm, "oracle_unseen_mm": oracle_mm})

    totals = totals_of(
        [
            of("case_001", "single", ["wind"], (2.0, 1.0), 0.5),
            of("case_002", "several", ["air_drag", "adhesion"], (2.0, 0.8), 0.8),
            of("case_003", "single", ["shrinkage"], (1.0, 1.03), 0.98),  # the oracle gains next to nothing
            of("case_004", "null", [], (1.0, 1.02)),
            of("case_005", "outside", ["magnet"], (1.0, 1.5)),
            of("case_006", "single", ["wind"], (None, 1.0)),
            of("case_007", "single", ["wind"], None),
        ]
    )
    assert (totals.unseen_ratio, totals.unseen_cases) == (0.5, 3)
    assert (totals.unseen_gap_closed, totals.unseen_gaps) == (pytest.approx((1.0 / 1.5 + 1.0) / 2), 2)
    assert totals.unseen_worse == ("case_003", "case_005")
