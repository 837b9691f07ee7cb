"""Where a campaign keeps what, and the two small files that it goes by: the drawn list and a record of each case."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import pydantic

from sim1.mismatch.strict_json import Strict, write_json
from sim1.proof.draw import Case
from sim1.whole_file import whole_file


class Drawn(Strict):
    """`answers/drawn.json`: all that the campaign will be asked, and nothing that the diagnosis may see."""

    schema_: Literal["sim1.proof.drawn/1"] = pydantic.Field(default="sim1.proof.drawn/1", alias="schema")
    nonce: str  # by chance: without it, a list could be guessed from its hash
    seed: str | None  # of the draw, an integer too long for some readers; None: the cases were chosen
    by_chance: bool | None = (
        None  # whether the seed is fresh entropy; None: there is none, or earlier code did not tell
    )
    laboratory: tuple[str, ...]
    cases: tuple[Case, ...]


class Record(Strict):
    """`records/CASE.json`: how filming or diagnosing ended. Written last: what has none was not finished."""

    case: str
    step: Literal["film", "seal", "diagnose"]  # the last one that was tried
    error: str | None  # why it failed
    seconds: pydantic.NonNegativeFloat | None  # of the diagnosis, all of it
    limit_s: pydantic.PositiveFloat | None = None  # that it might take; None: earlier code, which did not tell
    not_foretold: dict[str, str] = pydantic.Field(default_factory=dict)  # model -> why it foretells no motion
    code_sha256: str  # of the diagnosing code before it
    code_changed: bool  # meanwhile
    cores: pydantic.PositiveInt  # of the machine
    parallel: pydantic.PositiveInt  # cases at once


class Oracle(Strict):
    """`oracles/CASE.json`: what a model that is told the concealed effects comes to."""

    case: str
    heldout_mm: pydantic.NonNegativeFloat | None  # None: no simulation of it found its way
    unseen_mm: pydantic.NonNegativeFloat | None = None  # on motions that no diagnosis was given; None: not known
    lost: dict[str, str] = pydantic.Field(default_factory=dict)  # heldout or unseen -> why no simulation found its way
    seconds: pydantic.NonNegativeFloat


class Sparse(Strict):
    """What sparse regression with the same effects says."""

    named: tuple[str, ...] | None  # None: the baseline could not be pulled along a recording
    heldout_mm: pydantic.NonNegativeFloat | None  # None: no simulation with what it names found its way
    seconds: pydantic.NonNegativeFloat


class Generic(Strict):
    """What a residual without a name comes to."""

    heldout_mm: pydantic.NonNegativeFloat | None  # None: no simulation of it found its way
    seconds: pydantic.NonNegativeFloat


class Baselines(Strict):
    """`baselines/CASE.json`: what simpler methods make of a case."""

    case: str
    sindy: Sparse | None = None  # None: not asked yet
    residual: Generic | None = None


@dataclass(frozen=True)
class Files:
    """Places below the folder of a campaign. Names of cases say nothing of what is in them."""

    root: Path

    @property
    def drawn(self) -> Path:
        """The drawn list."""
        return self.root / "answers" / "drawn.json"

    def answers(self, case: str) -> Path:
        """Answers of a case; its arrays lie beside it."""
        return self.root / "answers" / f"{case}.json"

    def bundle(self, case: str) -> Path:
        """What the diagnosis is given."""
        return self.root / "bundles" / case

    def sealed(self, case: str) -> list[Path]:
        """What is committed to before a case is diagnosed: its answers, and every film."""
        answers, folders = self.answers(case), (self.bundle(case), self.unseen(case))
        films = sorted(path for folder in folders for path in folder.rglob("*") if path.is_file())
        return [answers, answers.with_suffix(".npz"), *films]

    def unseen(self, case: str) -> Path:
        """A bundle of other motions of the same cloth, to be foretold; the diagnosis is not given it."""
        return self.root / "unseen" / case

    def foretold(self, case: str, model: str) -> Path:
        """How one of the models that the diagnosis wrote foretells them."""
        return self.root / "foretold" / case / f"{model}.parquet"

    def findings(self, case: str) -> list[Path]:
        """Folders of what the diagnosis of a case wrote, and its models foretold."""
        return [self.found(case), self.root / "foretold" / case]

    def written(self, case: str) -> list[Path]:
        """All files in them, which are sealed when it ends."""
        return sorted(path for folder in self.findings(case) for path in folder.rglob("*") if path.is_file())

    def found(self, case: str) -> Path:
        """What the diagnosis wrote."""
        return self.root / "found" / case

    def record(self, case: str) -> Path:
        """How it ended."""
        return self.root / "records" / f"{case}.json"

    def oracle(self, case: str) -> Path:
        """What the oracle said, if it was asked."""
        return self.root / "oracles" / f"{case}.json"

    def outcome(self, case: str) -> Path:
        """How it was scored: all that a report needs where the case was filmed and diagnosed elsewhere."""
        return self.root / "outcomes" / f"{case}.json"

    def carried(self, case: str) -> bool:
        """Whether a case was scored elsewhere: how, is known, and its answers are not here."""
        return self.outcome(case).is_file() and not self.answers(case).is_file()

    @property
    def again(self) -> "Files":
        """The same places for films of such cases that were made again."""
        return Files(self.root / "again")

    def baselines(self, case: str) -> Path:
        """What simpler methods made of it, if they were asked."""
        return self.root / "baselines" / f"{case}.json"


def case_names(count: int) -> tuple[str, ...]:
    """`case_001`, `case_002`, ..."""
    return tuple(f"case_{number:03d}" for number in range(1, count + 1))


def write_model(path: Path, content: Strict) -> None:
    """Write a model so that it is there as a whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as part:
        write_json(part, content)
