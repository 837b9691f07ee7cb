"""The examination of a bundle: what is wrong with it, and when it reads, what its recordings can and cannot tell apart."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from sim1.recording.bundle import Bundle, examine_bundle
from sim1.recording.figures import RecordingFigures, measure
from sim1.recording.overall import Overall, overall
from sim1.recording.problems import Several
from sim1.recording.rule_table import RULES
from sim1.recording.rules import Statement, statements
from sim1.recording.sufficient import require_for_diagnosis
from sim1.recording.unspread import unspread

SCHEMA = "sim1.recordings-check/1"


@dataclass(frozen=True, kw_only=True)
class Examination:
    """Result of examining one bundle."""

    bundle: Path
    problems: tuple[str, ...]  # why it does not read
    wanting: tuple[str, ...]  # it reads, but a diagnosis needs more
    recordings: tuple[RecordingFigures, ...]  # empty where it does not read
    figures: Overall
    statements: tuple[Statement, ...]

    @property
    def usable(self) -> bool:
        """Whether a diagnosis can be made from it."""
        return not self.problems and not self.wanting

    def as_json(self) -> dict[str, Any]:
        """JSON values, schema `sim1.recordings-check/1`."""
        return {
            "schema": SCHEMA,
            "bundle": str(self.bundle),
            "reads": not self.problems,
            "usable": self.usable,
            "problems": list(self.problems),
            "wanting": list(self.wanting),
            "recordings": [_row(figures) for figures in self.recordings],
            "figures": self.figures,
            "statements": [{**vars(said), "effects": list(said.effects)} for said in self.statements],
        }


def examine(folder: Path) -> Examination:
    """Examine a bundle; damage is part of the result, not an error."""
    bundle, problems = examine_bundle(folder)
    if bundle is None:
        return Examination(bundle=folder, problems=problems, wanting=(), recordings=(), figures={}, statements=())
    try:
        require_for_diagnosis(bundle)
        wanting: tuple[str, ...] = ()
    except Several as error:
        wanting = error.messages
    recordings = [measure(bundle, recording) for recording in bundle.recordings]
    figures = overall(bundle, recordings)
    return Examination(
        bundle=folder,
        problems=(),
        wanting=wanting,
        recordings=tuple(recordings),
        figures=figures,
        statements=(*statements(figures, RULES), *_of_priors(bundle)),
    )


def cannot_tell(bundle: Bundle) -> tuple[Statement, ...]:
    """What the recordings of a bundle cannot tell, and what to record for it."""
    figures = overall(bundle, [measure(bundle, recording) for recording in bundle.recordings])
    return tuple(said for said in statements(figures, RULES) if not said.can)


def _of_priors(bundle: Bundle) -> list[Statement]:
    """What is said of priors without a spread, or that nothing is wanting."""
    said = [
        Statement(
            effects=(),
            can=False,
            text=f"priors: {text}",
            record="state std (or log_std, where the value is not 0): how sure you are of it",
        )
        for text in unspread(bundle)
    ]
    whole = "priors: all that a diagnosis calibrates have a spread"
    return said or [Statement(effects=(), can=True, text=whole, record="")]


def _row(figures: RecordingFigures) -> dict[str, Any]:
    values = {field.name: getattr(figures, field.name) for field in fields(figures) if field.name != "faces"}
    return {**values, "noise": None if figures.noise is None else vars(figures.noise)}
