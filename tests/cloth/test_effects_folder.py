"""An effect is there once its file lies in the folder."""

import sys

import pytest

from sim1.cloth.effects import EFFECTS, effects_in

COLD = """
from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect


@dataclass(frozen=True, kw_only=True)
class Cold(Effect):
    name: ClassVar[str] = "cold"
    signature: ClassVar[str] = "bends less the colder it is"
    source: ClassVar[str] = "made up"
    typical: ClassVar[str] = "0 to 0.5"
    varied: ClassVar[str] = "in a warm room"
    coefficients: ClassVar[tuple] = (Coefficient(name="share", unit="1", scale=0.1, low=0.0),)
    share: float

    @classmethod
    def alter(cls, world, values):
        return replace(world, bending_n_m=world.bending_n_m * (1.0 + values["share"]))
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    made = tmp_path / "further_effects"
    made.mkdir()
    (made / "__init__.py").write_text("")
    (made / "cold.py").write_text(COLD)
    yield made
    for name in [name for name in sys.modules if name.startswith("further_effects")]:
        del sys.modules[name]


def test_a_file_is_all_that_an_effect_needs(folder):
    found = effects_in("further_effects", [str(folder)])
    assert list(found) == ["cold"]
    assert found["cold"](share=0.2).units() == {"share": "1"}


@pytest.mark.parametrize("lacking", ["signature", "source", "typical", "varied", "coefficients", "alter"])
def test_what_a_search_or_a_report_asks_of_an_effect_is_missed_as_it_is_found(folder, lacking):
    lines = COLD.replace("def alter", "def other").splitlines() if lacking == "alter" else COLD.splitlines()
    (folder / "cold.py").write_text("\n".join(line for line in lines if not line.startswith(f"    {lacking}:")))
    with pytest.raises(ValueError, match=rf"cold\.py: Cold lacks {lacking}; effect\.py says"):
        effects_in("further_effects", [str(folder)])


def test_what_a_file_takes_from_another_is_no_effect_of_its_own(folder):
    (folder / "helper.py").write_text(
        "from sim1.cloth.effects.air_drag import AirDrag\nfrom sim1.cloth.effects import Effect\n"
    )
    assert list(effects_in("further_effects", [str(folder)])) == ["cold"]


def test_two_effects_of_one_name_are_refused(folder):
    (folder / "colder.py").write_text(COLD)
    with pytest.raises(ValueError, match=r"colder\.py: cold is the name of .* further_effects\.cold, too"):
        effects_in("further_effects", [str(folder)])


def test_effects_stand_by_their_names_in_files_of_these_names():
    assert list(EFFECTS) == sorted(EFFECTS)
    assert {name: effect.__module__ for name, effect in EFFECTS.items()} == {
        name: f"sim1.cloth.effects.{name}" for name in EFFECTS
    }
