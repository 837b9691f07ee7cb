"""The page of a diagnosis, put together from a verdict and a summary that are given."""

from html.parser import HTMLParser

import pytest

from sim1.mismatch.page import CAPTIONS, write_page
from sim1.mismatch.summary import SCHEMA, Prices, Summary
from sim1.mismatch.verdict import Verdict

VOTE = "lift_b, which no fit saw, had no vote: the error there is of a model that was chosen without it"
NEXT = "repeat swing_a, in which grip_compliance and grip_slip differ most"
ERRORS = {"fit": 1e-3, "heldout": 2e-3}
VERDICT = {
    "schema": "sim1.verdict/1",
    "verdict": "ambiguous",
    "noise_std_m": 3e-4,
    "rmse_m": {"baseline": ERRORS, "augmented": ERRORS},
    "mismatch": {"regions": [], "windows": [], "signature": "made up"},
    "missing_physics": [
        {
            "name": "grip_compliance",
            "probability": 0.61,
            "parameters": {"stiffness": {"value": 432.1, "ci95": [300.0, 600.0], "unit": "N/m"}},
            "heldout_rmse_reduction": 0.37,
        }
    ],
    "alternatives": [],
    "next_experiment": NEXT,
    "remarks": [VOTE],
}
SUMMARY = {
    "schema": SCHEMA,
    "sentence": "made up",
    "fitted": ["swing_a"],
    "heldout": ["lift_b"],
    "heldout_nats": -20.0,
    "spoken_for": [],
    "withdrawn": [],
    "converged": True,
    "creep_m": 0.0,
    "misfit": {"baseline": 2.0, "chosen": 1.0, "limit": 1.3, "alone": 2.5, "heldout": 1.72, "table": False},
    "prices": dict.fromkeys(Prices.model_fields, 1),
    "ranking": [],
    "estimates": [
        {"name": "bending_n_m", "unit": "N m", "prior": 2e-5, "value": 3e-5, "low": 2.5e-5, "high": 3.5e-5},
        {"name": "compliance", "unit": "m/N", "prior": 0.0, "value": 2.3e-3, "low": 1.7e-3, "high": 3.3e-3},
    ],
    "effects": ["grip_compliance"],
    "detectable": [],
    "states": [],
    "undecided": [
        {"what": "whether it is grip_compliance or grip_slip", "record": NEXT},
        {
            "what": "plastic_crease: the cloth is never folded onto itself",
            "record": "fold it, press, and open it again",
        },
    ],
}


class Rows(HTMLParser):
    """The text of every row of a page's tables, cell by cell."""

    def __init__(self, page):
        super().__init__()
        self.rows, self.inside = [], False
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        if tag == "tr":
            self.rows.append([])
        elif tag in ("td", "th"):
            self.rows[-1].append("")
            self.inside = True

    def handle_endtag(self, tag):
        if tag in ("td", "th"):
            self.inside = False

    def handle_data(self, data):
        if self.inside:
            self.rows[-1][-1] += data


@pytest.fixture
def page(tmp_path):
    """Writes the page of a verdict and a summary with some parts changed."""

    def write(verdict=None, summary=None):
        for name in CAPTIONS:
            (tmp_path / name).write_bytes(b"a picture")
        out = tmp_path / "report.html"
        write_page(
            out,
            Verdict.model_validate(VERDICT | (verdict or {})),
            Summary.model_validate(SUMMARY | (summary or {})),
            tmp_path,
        )
        return out.read_text()

    return write


def test_the_model_is_told_in_the_parameters_that_are_published_and_not_as_it_was_searched(page):
    rows = Rows(page()).rows
    assert ["grip_compliance", "0.61", "falls by 37 %", "stiffness", "432.1", "300 to 600", "N/m"] in rows
    assert not [row for row in rows if "m/N" in row]


def test_what_was_calibrated_beside_it_is_told_with_its_prior(page):
    assert ["bending_n_m", "2e-05", "3e-05", "2.5e-05 to 3.5e-05", "N m"] in Rows(page()).rows


def test_an_error_that_rises_or_is_not_known_is_said_so(page):
    [effect] = VERDICT["missing_physics"]
    for reduction, said in ((-0.04, "rises by 4 %"), (None, "not known")):
        changed = {"missing_physics": [effect | {"heldout_rmse_reduction": reduction}]}
        assert any(said in row for row in Rows(page(changed)).rows)


def test_where_nothing_was_added_no_model_is_shown(page):
    changed = {"verdict": "none", "missing_physics": []}
    assert "Nothing was added to the calibrated baseline" in page(changed, {"effects": [], "estimates": []})


def test_what_is_undecided_stands_beside_the_recording_that_would_decide_it(page):
    rows = Rows(page()).rows
    assert ["whether it is grip_compliance or grip_slip", NEXT] in rows
    assert ["plastic_crease: the cloth is never folded onto itself", "fold it, press, and open it again"] in rows


def test_whether_motion_held_out_had_a_vote_is_told(page):
    assert VOTE in page()


def test_what_the_model_leaves_in_motion_that_no_fit_saw_is_told_beside_the_limit_where_it_is_known(page):
    assert "a mean square of 1.00 where it was fitted and\n1.72 where it was not" in page()
    unknown = page(summary={"misfit": SUMMARY["misfit"] | {"heldout": None}})
    assert "where it was not" not in unknown


def test_where_nothing_is_undecided_no_table_of_it_is_shown(page):
    said = page(summary={"undecided": ()})
    assert "the recording that would decide" not in said
    assert NEXT in said
