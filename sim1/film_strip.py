"""Film strips: what became of a garment as a row of pictures, and which of many runs are shown."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap

import numpy as np
from matplotlib.figure import Figure

from sim1.array_file import read_arrays
from sim1.episode import RATE_HZ

WIDTH, HEIGHT = 160, 120  # px of a picture
PICTURES = 6  # in a strip
TITLE_CHARACTERS = 120  # of a line that is as wide as a strip
SUCCESS = "success"

type Look = Callable[[np.ndarray], np.ndarray]
"""Garment (v, 3) -> picture (h, w, 3) u8."""


@dataclass(frozen=True, kw_only=True)
class FilmStrip:
    """One run as a row of pictures."""

    title: str
    times_s: tuple[float, ...]
    pictures: tuple[np.ndarray, ...]


@dataclass(frozen=True, kw_only=True)
class Shown:
    """The run that stands for an outcome."""

    place: int  # of the first run with that outcome
    outcome: str
    count: int  # of all runs with it

    def of(self, total: int) -> str:
        """Begin of a title: which outcome, and how often."""
        return f"{self.outcome} ({self.count} of {total})"


def first_of_each(outcomes: Sequence[str], good: str = SUCCESS) -> list[Shown]:
    """The first run of every outcome, so that nobody chooses; the good one, then the others, frequent ones before rare ones."""
    counts = Counter(outcomes)
    order = sorted(counts, key=lambda outcome: (outcome != good, -counts[outcome], outcome))
    return [Shown(place=list(outcomes).index(outcome), outcome=outcome, count=counts[outcome]) for outcome in order]


def film_strip(title: str, history_m: np.ndarray, look: Look) -> FilmStrip:
    """Evenly spaced pictures of a garment's run (T, v, 3), first and last frame included."""
    frames = evenly(len(history_m))
    return FilmStrip(
        title=title,
        times_s=tuple(frame / RATE_HZ for frame in frames),
        pictures=tuple(look(history_m[frame]) for frame in frames),
    )


def evenly(count: int) -> list[int]:
    """Places of a strip's pictures among `count`."""
    return sorted({round(place) for place in np.linspace(0, count - 1, PICTURES)})


def laid_down(x_m: float, y_m: float, turn_rad: float) -> str:
    """Where the garment lay at the start, in words."""
    return f"moved {round(1e3 * x_m):+d}, {round(1e3 * y_m):+d} mm, turned {round(np.degrees(turn_rad)):+d}°"


def draw_strips(heading: str, strips: Sequence[FilmStrip]) -> Figure:
    """One strip below the other."""
    titles = [wrap(strip.title, TITLE_CHARACTERS) for strip in strips]
    heights = [1.28 + 0.14 * len(lines) for lines in titles]  # in
    figure = Figure(figsize=(1.5 * PICTURES, 0.35 + sum(heights)), layout="constrained")
    figure.get_layout_engine().set(w_pad=0.02, h_pad=0.02)
    figure.suptitle(heading, fontsize=11)
    parts = np.atleast_1d(figure.subfigures(len(strips), 1, height_ratios=heights))
    for part, strip, lines in zip(parts, strips, titles, strict=True):
        part.suptitle("\n".join(lines), fontsize=8.5, x=0.01, ha="left")
        places = part.subplots(1, PICTURES, squeeze=False)[0]
        for axes, time_s, picture in zip(places, strip.times_s, strip.pictures):
            axes.imshow(picture)
            axes.set_xlabel(f"{time_s:.1f} s", fontsize=7, labelpad=1)
            axes.set(xticks=[], yticks=[])
        for axes in places[len(strip.pictures) :]:  # a run that broke at once is shorter
            axes.set_axis_off()
    return figure


def write_strip(path: Path, strip: FilmStrip) -> None:
    """Keep a strip until all runs are made and those to be shown are known."""
    np.savez_compressed(path, title=strip.title, times_s=strip.times_s, pictures=np.stack(strip.pictures))


def read_strip(path: Path) -> FilmStrip:
    """What `write_strip` wrote.

    Raises:
        BadInput: the file is missing or damaged.
    """
    data = read_arrays(path, ("title", "times_s", "pictures"), "film strip")
    return FilmStrip(
        title=str(data["title"]), times_s=tuple(data["times_s"].tolist()), pictures=tuple(data["pictures"])
    )
