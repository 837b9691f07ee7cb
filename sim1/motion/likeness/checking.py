"""Answers of the check of stage motion_likeness."""

import json
import math
from pathlib import Path
from typing import Any

from sim1.motion.likeness.limits import in_words
from sim1.stage import Finding

FILES = ("likeness.json", "report.html", "likeness.png")


def findings(artifact: Path) -> list[Finding]:
    """Files are there and figures are numbers or say why not (blocking); each limit (a warning)."""
    try:
        record = json.loads((artifact / "likeness.json").read_text())
        empty = [name for name in FILES if not (artifact / name).stat().st_size]
        figures, limits = record["figures"], record["limits"][record["method"]]
    except (OSError, ValueError, KeyError) as error:
        return [
            Finding(name="files_readable", passed=False, detail=f"{artifact}: {error!r}; make motion_likeness again")
        ]
    unsound = [
        f"{owner} {name}: {figure}"
        for owner, row in figures.items()
        for name, figure in row.items()
        if not _sound(figure)
    ]
    return [
        Finding(name="files_readable", passed=not empty, detail=f"empty files: {', '.join(empty) or 'none'}"),
        Finding(
            name="figures_finite_or_not_measured",
            passed=not unsound,
            detail="; ".join(unsound) or f"{sum(map(len, figures.values()))} figures of {len(figures)} sets",
        ),
        *[
            Finding(name=f"limit_{row['figure']}", passed=row["met"] is not False, detail=in_words(row), blocking=False)
            for row in limits
        ],
    ]


def _sound(figure: dict[str, Any]) -> bool:
    if "value" not in figure:
        return bool(figure.get("not_measured"))
    return all(math.isfinite(value) for value in figure.values())
