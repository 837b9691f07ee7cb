"""Film strips of trials: of every source of training the first success and the first failure of each class."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from sim1.film_strip import SUCCESS, FilmStrip, draw_strips, first_of_each, read_strip
from sim1.policy.lessons import KINDS


def draw_trials(rows: Sequence[Mapping[str, Any]], files: Sequence[Path]) -> dict[str, Figure]:
    """A picture per shift. `files`: the strip of every trial, in the order of the rows."""
    shifts = dict.fromkeys(row["shift"] for row in rows)
    return {
        shift: draw_strips(
            f"Closed loop in the {' and the '.join(_worlds(rows, shift))}, {shift}: the first trial of each outcome",
            chosen(rows, files, shift),
        )
        for shift in shifts
    }


def chosen(rows: Sequence[Mapping[str, Any]], files: Sequence[Path], shift: str) -> list[FilmStrip]:
    """The strips of a shift that are shown: a title says outcome, how often it came, who drove, and where the garment lay."""
    strips = []
    for kind in KINDS:
        places = [at for at, row in enumerate(rows) if (row["shift"], row["trained_on"]) == (shift, kind)]
        outcomes = [SUCCESS if rows[at]["success"] else rows[at]["failure"] for at in places]
        for shown in first_of_each(outcomes):
            strip = read_strip(files[places[shown.place]])
            strips.append(replace(strip, title=f"{shown.of(len(places))}: {strip.title}"))
    return strips


def _worlds(rows: Sequence[Mapping[str, Any]], shift: str) -> list[str]:
    return sorted({row["world"] for row in rows if row["shift"] == shift})
