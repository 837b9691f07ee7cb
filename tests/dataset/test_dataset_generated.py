"""A folder of generated episodes becomes a dataset: what was accepted and nothing else, also after a kill."""

import json
from pathlib import Path

import pandas as pd
import pytest
from towel_cell import episode, write_inputs

import sim1.dataset.generated
from sim1.dataset.generated import accepted_episodes, dataset_of_generated
from sim1.dataset.stage import DatasetConfig
from sim1.episode import write_episode
from sim1.render.job import Job
from sim1.render.stage import RenderConfig
from sim1.stage import BadInput, Finding

RENDER = RenderConfig(width=32, height=24, samples=1, rate_hz=10, variants=1, device="cpu")
ATTEMPTS = {"0000": True, "0001": False, "0002": True}  # whether it was accepted


def row(name: str, accepted: bool) -> dict:
    """What `sim1 generate` keeps of an attempt, as far as a dataset is made of it."""
    rules = {"rules_pass": accepted, "rules_broken": "" if accepted else "height_m above 0.1"}
    video = {"video_score": 0.75, "video_pass": True, "video_abstains": False}
    judged = {"success": True, "failure": None, "perturbed": False}
    return {"episode": name, "accepted": accepted, **judged, **rules, **video}


@pytest.fixture
def generated(tmp_path) -> Path:
    """A folder of `sim1 generate` with two accepted episodes of three."""
    folder = tmp_path / "generated"
    (folder / "attempts").mkdir(parents=True)
    (folder / "plan.json").write_text(json.dumps({"garment": "towel", "variant": None, "setting.seed": 4}))
    for place, (name, accepted) in enumerate(ATTEMPTS.items()):
        write_episode(folder / "episodes" / name, episode(13 + 3 * place))
        (folder / "attempts" / f"{name}.json").write_text(json.dumps(row(name, accepted)))
    return folder


@pytest.fixture
def inputs(tmp_path):
    (tmp_path / "inputs").mkdir()
    given = write_inputs(tmp_path / "inputs")
    del given["valid_trajectories"]
    return given | {"robot": {"": Path(__file__).parents[2] / "data" / "robot"}}


@pytest.fixture
def blender(monkeypatch):
    """Paints frames in place of Blender; returns their paths."""
    painted: list[str] = []

    def paint(folder: Path, out: Path) -> None:
        import numpy as np
        from PIL import Image

        job = Job.read(folder)
        for clip, camera, frame in job.frames():
            path = job.frame_path(out, clip, camera, frame)
            if path.exists():
                continue
            if len(painted) == paint.limit:
                raise KeyboardInterrupt
            blocks = np.random.default_rng(frame).integers(0, 255, (3, 4, 3)).astype(np.uint8)
            image = blocks.repeat(8, axis=0).repeat(8, axis=1)  # finer noise is more than a video codec keeps
            path.parent.mkdir(parents=True, exist_ok=True)
            Image.fromarray(image).save(path)
            painted.append(str(path))

    paint.limit, paint.painted = 10**6, painted
    monkeypatch.setattr("sim1.render.blender.run_blender", paint)
    monkeypatch.setattr(sim1.dataset.generated, "check_rendered_episodes", lambda folder: [])  # noise shows no garment
    return paint


def write(generated, inputs, out):
    return dataset_of_generated(generated, inputs, "towel", RENDER, DatasetConfig(), out)


def test_accepted_episodes_are_rendered_and_written_under_names_that_tell_the_seed(
    generated, inputs, blender, tmp_path
):
    facts = write(generated, inputs, tmp_path / "out")
    assert facts["episodes"] == 2
    provenance = pd.read_parquet(tmp_path / "out" / "dataset" / "provenance.parquet")
    assert provenance["trajectory"].tolist() == ["seed4_0000", "seed4_0002"]
    assert provenance["frame_count"].tolist() == [5, 7]
    said = [json.loads(scores) for scores in provenance["scores"]]
    assert [(one["rules_pass"], one["video_score"], one["accepted"]) for one in said] == [(True, 0.75, True)] * 2
    assert not (tmp_path / "out" / "dataset.part").exists()
    with pytest.raises(BadInput, match=r"out/dataset: exists; give another folder"):
        write(generated, inputs, tmp_path / "out")


def test_a_killed_rendering_goes_on(generated, inputs, blender, tmp_path):
    blender.limit = 8
    with pytest.raises(KeyboardInterrupt):
        write(generated, inputs, tmp_path / "out")
    assert not (tmp_path / "out" / "dataset").exists()
    blender.limit = 10**6
    write(generated, inputs, tmp_path / "out")
    assert len(blender.painted) == len(set(blender.painted)) == 12


def test_frames_that_show_nothing_become_no_dataset(generated, inputs, blender, tmp_path, monkeypatch):
    dark = Finding(name="frames_lit", passed=False, detail="mean 0.0")
    monkeypatch.setattr(sim1.dataset.generated, "check_rendered_episodes", lambda folder: [dark])
    with pytest.raises(BadInput, match=r"out/rendered: frames_lit: mean 0\.0"):
        write(generated, inputs, tmp_path / "out")
    assert not (tmp_path / "out" / "dataset").exists()


def test_a_folder_without_anything_accepted_or_of_something_else_is_named(generated, tmp_path):
    for name in ATTEMPTS:
        (generated / "attempts" / f"{name}.json").write_text(json.dumps({"episode": name, "accepted": False}))
    with pytest.raises(BadInput, match="none of 3 attempts was accepted"):
        accepted_episodes(generated)
    with pytest.raises(BadInput, match="not a readable folder of `sim1 generate`"):
        accepted_episodes(tmp_path)
