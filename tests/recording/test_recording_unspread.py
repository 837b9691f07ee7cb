"""A prior without a spread is taken as exact, and the check and the verdict say so."""

from dataclasses import replace

import pytest
from swinging import board_bundle, swing

from sim1.mismatch.search import baseline
from sim1.recording.bundle import write_bundle
from sim1.recording.document import Friction, Prior, Table
from sim1.recording.examination import examine
from sim1.recording.unspread import UNITS, unspread


def without_spread(bundle, *names):
    """The bundle with nothing but a value for some properties of the fabric."""
    bare = {name: Prior(value=getattr(bundle.prior, name).value) for name in names}
    return replace(bundle, prior=bundle.prior.model_copy(update=bare))


def on_table(bundle, **friction):
    return replace(
        bundle,
        environment=bundle.environment.model_copy(update={"table": Table(height_m=0.0, friction=Friction(**friction))}),
    )


def searched(bundle):
    return {coefficient.name: coefficient.scale for coefficient in baseline(bundle).nominal}


@pytest.fixture(scope="module")
def stated():
    return on_table(board_bundle(swing("a"), swing("b")), value=0.4, std=0.2)


def test_where_all_have_a_spread_nothing_is_said_and_all_is_calibrated(stated):
    assert unspread(stated) == []
    assert {*UNITS, "poisson", "friction"} <= set(searched(stated))


@pytest.mark.parametrize("name", UNITS)
def test_what_is_said_to_be_taken_as_exact_is_what_no_search_varies(stated, name):
    bundle = without_spread(stated, name)
    assert set(searched(stated)) - set(searched(bundle)) == {name}
    [said] = unspread(bundle)
    assert (
        f"no spread to garment.prior.{name} ({getattr(bundle.prior, name).value:g} {UNITS[name]}): taken as exact"
        in said
    )


@pytest.mark.parametrize("friction", [{"value": 0.4}, {"value": 0.0, "log_std": 0.5}])
def test_a_friction_of_which_nothing_is_known_but_its_value_is_taken_as_exact_too(stated, friction):
    bundle = on_table(stated, **friction)
    assert "friction" not in searched(bundle)
    assert unspread(bundle)[0].startswith(
        f"bundle.yaml gives no spread to environment.table.friction ({friction['value']:g})"
    )


def test_poissons_ratio_is_searched_all_the_same_and_what_is_assumed_of_it_is_said(stated):
    bundle = without_spread(stated, "poisson")
    assert searched(bundle)["poisson"] == 0.1
    [said] = unspread(bundle)
    assert said.endswith("garment.prior.poisson (0.3): 0.1 is assumed for its std")


def test_the_check_says_it_with_a_remedy(stated, tmp_path):
    write_bundle(tmp_path / "b", without_spread(stated, "stretch_n_m", "damping_s", "poisson"))
    found = [one for one in examine(tmp_path / "b").statements if one.text.startswith("priors:")]
    assert [one.can for one in found] == [False, False]
    assert "garment.prior.stretch_n_m (400 N/m), garment.prior.damping_s (0.001 s): taken as exact" in found[0].text
    assert "std" in found[0].record
    write_bundle(tmp_path / "whole", stated)
    assert [one.can for one in examine(tmp_path / "whole").statements if one.text.startswith("priors:")] == [True]
