"""What the page about the diagnosis says of effects and thresholds is what the code has."""

import pytest

from pipeline.home import REPOSITORY
from sim1.cloth.effects import EFFECTS
from sim1.mismatch.summary import SCHEMA
from sim1.mismatch.thresholds import THRESHOLDS

PAGE = (REPOSITORY / "docs" / "mismatch.md").read_text()


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_stands_in_the_table_with_how_it_shows(name):
    assert f"| `{name}` | {EFFECTS[name].signature} | {EFFECTS[name].typical} |" in PAGE


def test_thresholds_are_those_in_force():
    asked = THRESHOLDS
    for said in (
        f"a model is worth {asked.named:g} nats",
        f"gains {asked.second_share:.0%} of what the other gains".replace("%", " %"),
        f"the baseline's misfit is {asked.misfit:g} or more, or {asked.misfit_alone:g} in one recording |",
        f"from {asked.doubtful:g} of that on",
        f"its unsteadiness is at most {asked.unsteady:g}",
        f"adds {asked.named:g} to what the other is worth",
        f"more than {asked.steady:g} times",
        f"within {asked.margin:g} nats or {asked.margin_share:.1%} of its gain".replace("%", " %"),
        f"{asked.alone:g} times as much where that recording does not speak for the name, by {asked.spoken:g} nats",
        f"by {asked.spoken:g} nats or more, is asked for {asked.alone:g} times the worth",
        f"it explains {asked.explained:g} of the excess",
        f"{asked.explained_whole:g} of it where what it leaves",
        f"a mean square of {asked.left:g} at most",
        f"less {asked.per_term:g} for each effect",
        f"{asked.gain:g} were calibrated on {asked.nulls} virtual bundles",
    ):
        assert said in PAGE, said


@pytest.mark.parametrize("page", ["mismatch.md", "artifacts.md"])
def test_the_schema_is_the_one_that_is_written(page):
    assert f"`{SCHEMA}`" in (REPOSITORY / "docs" / page).read_text()
