"""An appearance in which the garment is not seen is drawn anew, the same way each time."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from planned_towel import CONFIG, FRAME
from towel_cell import write_inputs

import sim1.render.blender
import sim1.render.visible
from sim1.render.appearance_file import read_about
from sim1.render.job import Job
from sim1.render.stage import REDRAWN_AT_MOST, rendered_episodes


@dataclass
class Eyes:
    """Stands for the camera: on some tables the towel is not seen."""

    dull: Callable[[str], bool]


@pytest.fixture
def eyes(monkeypatch):
    """Frames of noise in place of Blender's."""
    eyes = Eyes(dull=lambda table: False)

    def paint(job_folder: Path, out: Path) -> None:
        job = Job.read(job_folder)
        for clip, camera, frame in job.frames():
            path = job.frame_path(out, clip, camera, frame)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(FRAME)

    def contrast(folder: Path, *_) -> float:
        return 3.0 if eyes.dull(table_of(folder.parent)) else 40.0

    monkeypatch.setattr(sim1.render.blender, "run_blender", paint)
    monkeypatch.setattr(sim1.render.visible, "_first_contrast", contrast)
    return eyes


def table_of(clip: Path) -> str:
    """All of it: one of the same name may be drawn in other colours."""
    return str(read_about(clip / "appearance.json")["appearance"]["table"])


def render(inputs, out: Path):
    out.mkdir(exist_ok=True)
    return rendered_episodes(inputs, out, CONFIG)


def tables(out: Path) -> list[str]:
    return [table_of(clip) for clip in sorted(out.glob("episodes/0000/v*"))]


def test_what_is_seen_stays_and_what_is_not_is_drawn_anew(eyes, tmp_path):
    inputs = write_inputs(tmp_path)
    assert render(inputs, tmp_path / "before")["drawn_again"] == 0
    first, second = tables(tmp_path / "before")
    eyes.dull = lambda table: table == second
    facts = render(inputs, tmp_path / "out")
    kept, changed = tables(tmp_path / "out")
    assert (facts["drawn_again"], facts["clips"]) == (1, 2)
    assert kept == first
    assert changed != second
    # Whatever lay there before, as after a kill or for an update: the same.
    render(inputs, tmp_path / "before")
    assert tables(tmp_path / "before") == [kept, changed]


def test_one_that_stays_unseen_is_left_to_the_check_after_some_draws(eyes, tmp_path):
    seen = []
    eyes.dull = lambda table: seen.append(table) or True
    facts = render(write_inputs(tmp_path), tmp_path / "out")
    assert facts["drawn_again"] == 2 * REDRAWN_AT_MOST
    assert len(set(seen)) == 2 * (1 + REDRAWN_AT_MOST)
