"""An appearance in which the garment is not seen is drawn anew, the same way each time."""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from planned_towel import CONFIG, FRAME
from towel_cell import episode, looking_at_origin, towel, write_inputs

import sim1.render.blender
import sim1.render.visible
from sim1.episode import write_episode
from sim1.render.appearance import SCHEMA
from sim1.render.appearance_file import read_about
from sim1.render.cameras import project
from sim1.render.job import Job
from sim1.render.stage import REDRAWN_AT_MOST, rendered_episodes
from sim1.render.visible import hidden_clips


@dataclass
class Eyes:
    """Stands for the camera: on some tables the towel is not seen."""

    dull: Callable[[str], bool]
    painted: list[tuple[str, int]] = field(default_factory=list)  # table and frame, of all frames that were not there
    dies_after: int | None = None  # so many of them


@pytest.fixture
def eyes(monkeypatch):
    """Frames of noise in place of Blender's."""
    eyes = Eyes(dull=lambda table: False)

    def paint(job_folder: Path, out: Path) -> None:
        job = Job.read(job_folder)
        for clip, camera, frame in job.frames():
            path = job.frame_path(out, clip, camera, frame)
            if path.exists():
                continue
            if len(eyes.painted) == eyes.dies_after:
                raise KeyboardInterrupt
            eyes.painted.append((str(asdict(clip.appearance.table)), frame))
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


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def killed(inputs, eyes, out: Path, frames: int) -> None:
    eyes.painted.clear()
    eyes.dies_after = frames
    with pytest.raises(KeyboardInterrupt):
        render(inputs, out)
    eyes.dies_after = None


def test_a_killed_run_goes_on_with_what_was_drawn_anew_and_leaves_what_one_that_was_not_killed_leaves(eyes, tmp_path):
    """The second look hides the towel, and the one that is drawn in its place as well."""
    inputs = write_inputs(tmp_path)
    render(inputs, tmp_path / "before")
    unseen = [tables(tmp_path / "before")[1]]
    eyes.dull = lambda table: table in unseen
    render(inputs, tmp_path / "once")
    unseen.append(tables(tmp_path / "once")[1])
    facts = render(inputs, tmp_path / "whole")
    assert facts["drawn_again"] == 2
    killed(inputs, eyes, tmp_path / "out", frames=14)  # four of each look: of the last draw two are made
    made = list(eyes.painted)
    assert render(inputs, tmp_path / "out") == facts
    assert len(eyes.painted) == 16
    assert len(set(eyes.painted)) == 16, "a frame was rendered twice"
    assert eyes.painted[:14] == made
    assert contents(tmp_path / "out") == contents(tmp_path / "whole")


def test_what_was_drawn_anew_for_other_looks_is_forgotten(eyes, tmp_path):
    inputs = write_inputs(tmp_path)
    render(inputs, tmp_path / "before")
    unseen = tables(tmp_path / "before")[1]
    eyes.dull = lambda table: table == unseen
    killed(inputs, eyes, tmp_path / "out", frames=10)
    file = inputs["appearance"]["towel"] / "fabrics.yaml"
    file.write_text(file.read_text() + "\n# mended\n")
    eyes.dull = lambda table: False
    assert render(inputs, tmp_path / "out")["drawn_again"] == 0
    assert contents(tmp_path / "out") == contents(tmp_path / "before")


def filmed(folder: Path, color: tuple[int, int, int], away_m: float = 0.0) -> Path:
    """An artifact of one frame: grey noise, with a patch of a colour where the towel lies, or would if it were not so far away."""
    run, camera = episode(1), looking_at_origin((-0.45, 0.0, 0.8))
    write_episode(folder / "episodes/0000", replace(run, garment_m=run.garment_m + np.float32(away_m)))
    clip = folder / "episodes/0000/v0"
    (clip / "head").mkdir(parents=True)
    head = {"width": 64, "height": 48, "fy_px": 42.0, "camera_to_world": camera.tolist(), "moves": False}
    (clip / "appearance.json").write_text(json.dumps({"schema": SCHEMA, "variant": 0, "cameras": {"head": head}}))
    np.savez(folder / "garment.npz", rest_m=towel()[0], faces=towel()[1])
    image = np.random.default_rng(0).integers(90, 130, (48, 64, 3)).astype(np.uint8)
    pixels, _ = project(towel()[0], camera_to_world=camera, fy_over_height=42 / 48, width=64, height=48)
    left, top = pixels.min(axis=0).astype(int)
    right, bottom = pixels.max(axis=0).astype(int) + 1
    image[top:bottom, left:right] = color
    Image.fromarray(image).save(clip / "head" / "000000.png")
    return folder


def test_a_towel_of_the_tables_colour_is_hidden_and_no_other_look_helps_one_out_of_the_picture(tmp_path):
    assert hidden_clips(filmed(tmp_path / "red", (200, 40, 30))) == []
    grey = filmed(tmp_path / "grey", (110, 110, 110))
    assert hidden_clips(grey) == [("0000", 0)]
    assert hidden_clips(filmed(tmp_path / "away", (110, 110, 110), away_m=5.0)) == []
    (grey / "episodes/0000/v0/head/000000.png").write_bytes(b"no picture")
    assert hidden_clips(grey) == []  # left to the check


def test_one_that_stays_unseen_is_left_to_the_check_after_some_draws(eyes, tmp_path):
    unseen = []
    eyes.dull = lambda table: unseen.append(table) or True
    facts = render(write_inputs(tmp_path), tmp_path / "out")
    assert facts["drawn_again"] == 2 * REDRAWN_AT_MOST
    assert len({*unseen, *tables(tmp_path / "out")}) == 2 * (1 + REDRAWN_AT_MOST)
