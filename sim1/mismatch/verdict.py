"""`verdict.json`, schema `sim1.verdict/1`: the answer for programs."""

from pathlib import Path
from typing import Literal

import pydantic

from sim1.mismatch.strict_json import Strict, read_json

type Share = pydantic.confloat(ge=0, le=1)


class Errors(Strict):
    """Root mean square per coordinate, m; None where no simulation follows one of the recordings to its end."""

    fit: pydantic.NonNegativeFloat | None
    # On motion that no fit has seen; whether it had a vote on what is named, `remarks` says.
    heldout: pydantic.NonNegativeFloat | None


class BothErrors(Strict):
    """Before and after the named additions; the same where nothing was added."""

    baseline: Errors
    augmented: Errors


class Region(Strict):
    """Markers and their share of the unexplained motion."""

    markers: list[int]
    share: Share


class Window(Strict):
    """A stretch of a recording and its share of the unexplained motion."""

    recording: str
    from_s: float
    to_s: float
    share: Share


class Mismatch(Strict):
    """Where, when and how."""

    regions: list[Region]
    windows: list[Window]
    signature: str


class Coefficient(Strict):
    """A fitted coefficient of an effect."""

    value: float
    ci95: tuple[float, float] | None
    unit: str


class Effect(Strict):
    """Physics that was left out."""

    name: str
    probability: Share
    parameters: dict[str, Coefficient]
    heldout_rmse_reduction: float | None  # by it beside what else was named; None: not known, see `remarks`


class Alternative(Strict):
    """An explanation that was considered and not taken."""

    name: str
    probability: Share
    why_not: str


class Verdict(Strict):
    """Contents of `verdict.json`."""

    schema_: Literal["sim1.verdict/1"] = pydantic.Field(default="sim1.verdict/1", alias="schema")
    verdict: Literal["none", "named", "ambiguous", "unknown"]
    noise_std_m: pydantic.PositiveFloat  # of the markers, per coordinate and frame
    rmse_m: BothErrors
    mismatch: Mismatch
    missing_physics: list[Effect]
    alternatives: list[Alternative]
    next_experiment: str
    remarks: tuple[str, ...] = ()  # what could not be computed, and what the bundle leaves out or contradicts

    @pydantic.model_validator(mode="after")
    def _consistent(self) -> "Verdict":
        if self.verdict == "none" and self.missing_physics:
            raise ValueError("the verdict is none and yet physics is missing")
        if self.verdict == "named" and not self.missing_physics:
            raise ValueError("the verdict is named without a name")
        return self


def in_mm(error_m: float | None) -> str:
    """An error as people read it."""
    return "an unknown error" if error_m is None else f"{1e3 * error_m:.2f} mm"


def read_verdict(path: Path) -> Verdict:
    """Read and check `verdict.json`.

    Raises:
        BadInput: missing, or not the schema.
    """
    return read_json(path, Verdict, "diagnose the bundle again")
