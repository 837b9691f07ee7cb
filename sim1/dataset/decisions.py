"""What judge, state rules and video discriminator said of an episode, for its provenance."""

import math
from pathlib import Path
from typing import Any

import pandas as pd

from sim1.dataset.tables import DAMAGED
from sim1.stage import BadInput

FILE = "decisions.parquet"
SAID = (
    "success",
    "failure",
    "perturbed",
    "rules_pass",
    "rules_broken",
    "video_score",
    "video_pass",
    "video_abstains",
    "accepted",
)


def read_decisions(artifact: Path) -> dict[str, dict[str, Any]]:
    """Of an artifact of `valid_trajectories`: what was said of each episode, by its name, as JSON values.

    Raises:
        BadInput: the file is missing, damaged or lacks a column.
    """
    path = artifact / FILE
    try:
        table = pd.read_parquet(path)
    except DAMAGED as error:
        raise BadInput(f"{path}: not readable decisions ({error}); make valid_trajectories again") from error
    if missing := [name for name in ("episode", *SAID) if name not in table]:
        raise BadInput(f"{path}: no column {', '.join(missing)}; make valid_trajectories again")
    return {row["episode"]: {name: _plain(row[name]) for name in SAID} for row in table.to_dict("records")}


def scores(about: dict[str, Any], decision: dict[str, Any] | None) -> dict[str, Any]:
    """JSON: the judge's `figures`, and what the filters decided; null where nobody asked them.

    A discriminator that abstains has neither passed nor refused the episode: its `video_pass` is null.

    Args:
        about: the episode's own file.
        decision: of `read_decisions`; None: there are no decisions.
    """
    said = dict.fromkeys(SAID) | {name: about.get(name) for name in ("success", "failure", "perturbed")}
    said |= decision or {}
    if said["video_abstains"]:
        said["video_pass"] = None
    return {"figures": about.get("figures"), **said}


def _plain(value: Any) -> Any:
    """A cell as a JSON value."""
    value = value.item() if hasattr(value, "item") else value
    return None if isinstance(value, float) and math.isnan(value) else value
