"""`summary.json`, schema `sim1.diagnosis/1`: what the page for a person says beyond the verdict, without the arrays it comes from."""

import json
from pathlib import Path
from typing import Literal

import pydantic

from sim1.stage import BadInput


class _Strict(pydantic.BaseModel):
    model_config = pydantic.ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Ranked(_Strict):
    """A model that was fitted."""

    name: str
    gain: float  # over the calibrated baseline, nats
    misfit: float  # mean squared residual in units of noise and mesh error


class Estimate(_Strict):
    """A coefficient of the chosen model, in its own unit."""

    name: str
    unit: str
    prior: float
    value: float
    low: float  # of the 95 % interval
    high: float


class Misfit(_Strict):
    """Mean squared residual on the fitted recordings, in units of noise and mesh error; 1 is all that can be asked."""

    baseline: float
    chosen: float
    limit: float  # from which something is taken to be missing


class Prices(_Strict):
    """What a name has to gain, nats."""

    per_term: float
    named: float
    margin: float


class Summary(_Strict):
    """Contents of `summary.json`."""

    schema_: Literal["sim1.diagnosis/1"] = pydantic.Field(default="sim1.diagnosis/1", alias="schema")
    sentence: str
    fitted: tuple[str, ...]  # recordings
    heldout: tuple[str, ...]  # seen by no fit and no choice
    converged: bool  # the searches of the baseline and of the chosen model
    misfit: Misfit
    prices: Prices
    ranking: tuple[Ranked, ...]
    estimates: tuple[Estimate, ...]
    effects: tuple[str, ...]  # of the chosen model


def read_summary(path: Path) -> Summary:
    """Read and check `summary.json`.

    Raises:
        BadInput: missing, or not the schema.
    """
    try:
        return Summary.model_validate_json(path.read_text())
    except OSError as error:
        raise BadInput(f"{path}: not readable ({error}); make calibrated_physics again") from error
    except pydantic.ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"])) or "top"
        raise BadInput(f"{path}: {place}: {first['msg']}; make calibrated_physics again") from error


def write_summary(path: Path, summary: Summary) -> None:
    """Write `summary.json`."""
    path.write_text(json.dumps(summary.model_dump(by_alias=True, mode="json"), indent=1) + "\n")
