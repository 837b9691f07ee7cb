"""`curve.json`: what the scaling report measured, for its own page and for the page of all results."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import pydantic

from sim1.clustered_share import Difference
from sim1.policy.counting import read_figures
from sim1.policy.equivalence import Worth
from sim1.policy.scaling import Point, PowerLaw, Task
from sim1.policy.success_law import SuccessLaw
from sim1.stage import BadInput

SCHEMA = "sim1.curve/8"


@dataclass(frozen=True, kw_only=True)
class Curve:
    """Points of all kinds of training, and what follows from them."""

    points: tuple[Point, ...]
    fits: tuple[PowerLaw, ...]
    success_fits: tuple[SuccessLaw | str, ...]  # a text says of which kind of training there is none, and why
    worths: tuple[Worth | str, ...]  # a text says why one is not known
    tasks: tuple[Task, ...]
    over_real: Mapping[str, Difference]  # shift, or average -> generated minus real
    worlds: Mapping[str, tuple[str, ...]]  # where trials took place -> garments


def write_curve(artifact: Path, curve: Curve) -> None:
    """Write `curve.json`."""
    found = {"schema": SCHEMA, **asdict(curve)}
    (artifact / "curve.json").write_text(json.dumps(found, indent=1, sort_keys=True) + "\n")


def read_curve(artifact: Path) -> Curve:
    """Read `curve.json`.

    Raises:
        BadInput: missing, damaged, or of another version.
    """
    path = artifact / "curve.json"
    found = read_figures(path, SCHEMA, "scaling_report")
    try:
        return pydantic.TypeAdapter(Curve).validate_python(found)
    except pydantic.ValidationError as error:
        raise BadInput(f"{path}: not a readable curve ({error}); make scaling_report again") from error
