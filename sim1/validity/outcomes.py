"""What became of every generated attempt, in one word, and film strips of the first of each."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sim1.episode import Episode, read_episode
from sim1.film_strip import Look, draw_strips, film_strip, first_of_each, laid_down
from sim1.picture_file import save_figure

OUTCOME = (
    "accepted",
    "success",
    "failure",
    "reasons",
    "perturbed",
)  # columns of the decisions that tell how an attempt ended
ACCEPTED, BY_RULE, BY_VIDEO = "accepted", "rejected by rule", "rejected by video"


def outcome(decision: Mapping[str, Any]) -> str:
    """Accepted, the judge's class of failure, or which filter rejected what the judge found well; of a row of the decisions."""
    if decision["accepted"]:
        return ACCEPTED if decision["success"] else f"accepted, though {decision['failure']}"
    if not decision["success"]:
        return str(decision["failure"])
    return BY_RULE if decision["reasons"].startswith("rules: ") else BY_VIDEO


def draw_outcomes(
    path: Path, garment: str, rows: Sequence[Mapping[str, Any]], episodes: Path, start_m: np.ndarray, look: Look
) -> None:
    """The first episode of each outcome, of the attempts that ran; no picture where none did.

    Args:
        path: of the picture.
        garment: its name.
        rows: all decisions.
        episodes: folder with those that ran.
        start_m: (v, 3), the garment before it is laid down for an attempt.
        look: what the head camera sees.
    """
    ran = [row for row in rows if row["ran"]]
    strips = []
    for shown in first_of_each([outcome(row) for row in ran], good=ACCEPTED):
        row = ran[shown.place]
        episode = read_episode(episodes / row["episode"])
        purpose = ", disturbed on purpose" if row["perturbed"] else ""
        title = f"{shown.of(len(ran))}: {garment}, {_origin(row, episode)}, {_place(episode.garment_m[0], start_m)}{purpose}"
        strips.append(film_strip(title, episode.garment_m, look))
    if strips:
        heading = f"Generated episodes of {garment}, simulated: the first of each outcome, of {len(ran)} that ran"
        save_figure(draw_strips(heading, strips), path, dpi=110)


def _origin(row: Mapping[str, Any], episode: Episode) -> str:
    return f"attempt {row['episode']} of seed {episode.about.get('seed', '?')}"


def _place(placed_m: np.ndarray, start_m: np.ndarray) -> str:
    """Best rigid motion from the settled garment to where the episode begins; settling on its own moves it by hairs alone."""
    before, after = (points[:, :2] - points[:, :2].mean(axis=0) for points in (start_m, placed_m))
    turn_rad = np.arctan2(np.sum(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]), np.sum(before * after))
    x_m, y_m = (placed_m - start_m).mean(axis=0)[:2]
    return laid_down(float(x_m), float(y_m), float(turn_rad))
