"""Trajectories become frames: in step with the states, repeatable, resumable."""

import json
import subprocess
import sys
import time
from pathlib import Path
from typing import get_args, get_type_hints

import numpy as np
import pytest
from opengl import with_opengl
from PIL import Image
from planned_towel import CONFIG, plan
from pydantic import ValidationError
from towel_cell import write_inputs

from sim1.episode import RATE_HZ
from sim1.progress import listening
from sim1.render.appearance_file import read_about
from sim1.render.shares import Order
from sim1.render.stage import RenderConfig, check_rendered_episodes, check_source_appearance, rendered_episodes
from sim1.stage import BadInput


@pytest.fixture
def inputs(tmp_path):
    return write_inputs(tmp_path)


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def render(inputs, out: Path, config: RenderConfig = CONFIG):
    out.mkdir(exist_ok=True)
    return rendered_episodes(inputs, out, config)


def test_a_trajectory_is_rendered_in_step_with_its_states_and_the_same_again_after_an_interruption(inputs, tmp_path):
    out = tmp_path / "out"
    seen = []
    with listening(lambda done, total, what: seen.append((done, total))):
        facts = render(inputs, out)
    assert (facts["clips"], facts["frames"]) == (2, 8)  # 7 states at 30 Hz are 4 frames at 15 Hz, twice
    assert seen[-1] == (8, 8)
    assert len(list(out.glob("episodes/0000/v1/head/*.png"))) == 4
    findings = check_rendered_episodes(out)
    assert all(finding.passed for finding in findings), findings
    assert (out / "contact_sheet.png").stat().st_size < 200_000

    first = contents(out)
    assert not any(name.endswith(".part") for name in first)
    assert read_about(out / "episodes/0000/v1/appearance.json")["rendered_on"] == ["cpu"]
    # Interrupted: one frame is gone, one is half-written under its temporary name.
    (out / "episodes/0000/v1/head/000001.png").unlink()
    (out / "episodes/0000/v1/head/000001.png.part").write_bytes(b"half")
    before = (out / "episodes/0000/v0/head/000000.png").stat().st_mtime_ns
    time.sleep(0.01)
    render(inputs, out)
    assert contents(out) == first
    assert (out / "episodes/0000/v0/head/000000.png").stat().st_mtime_ns == before

    # A frame shows the cell and nothing about the machine or the time.
    with Image.open(out / "episodes/0000/v0/head/000000.png") as image:
        assert image.size == (48, 36)
        assert image.info == {}


def test_the_same_seed_gives_the_same_bytes_however_many_workers_and_threads_there_are(tmp_path):
    inputs = write_inputs(tmp_path, frame_count=19)  # 10 frames in each look; both workers render the third
    for workers, threads in ((1, 2), (2, 1)):
        config = RenderConfig(**{**CONFIG.__dict__, "variants": 3, "workers": workers, "threads": threads})
        render(inputs, tmp_path / f"{workers} workers", config)
    assert len(list((tmp_path / "1 workers").glob("episodes/*/*/head/*.png"))) == 30
    assert contents(tmp_path / "1 workers") == contents(tmp_path / "2 workers")


def test_the_preview_engine_gives_the_same_frames_twice_and_shows_the_garment(inputs, tmp_path):
    config = RenderConfig(**{**CONFIG.__dict__, "engine": "workbench", "scanned_share": 1.0, "variants": 1})
    with with_opengl():
        render(inputs, tmp_path / "a", config)
    render(inputs, tmp_path / "b", config)
    assert contents(tmp_path / "a") == contents(tmp_path / "b")
    image = np.asarray(Image.open(tmp_path / "a/episodes/0000/v0/head/000000.png"), float)
    assert (image[..., 0] - image[..., 2])[18, 24] > 30  # the towel is red
    findings = check_rendered_episodes(tmp_path / "a")
    assert all(finding.passed for finding in findings), findings


def test_a_fault_in_the_looks_is_told_before_anything_is_rendered(inputs, tmp_path):
    file = inputs["appearance"]["towel"] / "tables.yaml"
    file.write_text(file.read_text().replace("kind: veins", "kind: vains", 1))
    with pytest.raises(BadInput, match=r"tables\.yaml: tables\.white_marble\.figure\.kind is 'vains'"):
        check_source_appearance(file.parent)
    with pytest.raises(BadInput, match="vains"):
        render(inputs, tmp_path / "out")


def test_the_garment_moves_in_the_picture_as_it_does_in_the_states(inputs, tmp_path):
    config = RenderConfig(
        width=96,
        height=72,
        samples=4,
        rate_hz=5,
        variants=1,
        cameras=("head", "left_wrist"),
        device="cpu",
        scanned_share=1.0,
    )
    render(inputs, tmp_path / "out", config)
    clip = tmp_path / "out/episodes/0000/v0"
    first, last = (np.asarray(Image.open(clip / "head" / f"{i:06d}.png"), float) for i in (0, 1))
    about = json.loads((clip / "appearance.json").read_text())
    assert about["stride"] == 6
    assert about["cameras"]["left_wrist"]["moves"]
    # The towel is red and covers the middle; what changes is there or where the arms turn, not in the far corners.
    red = first[..., 0] - first[..., 2]
    assert red[36, 48] > 30
    # Noise is another in every frame: it is averaged away.
    change = (last - first).reshape(9, 8, 12, 8, 3).mean(axis=(1, 3))
    assert np.abs(change).max() > 20
    assert np.abs(change[-1, 0]).max() < 5
    wrist = [np.asarray(Image.open(clip / "left_wrist" / f"{i:06d}.png"), float) for i in (0, 1)]
    assert np.abs(wrist[1] - wrist[0]).mean() > 1.0


def test_a_worker_whose_parent_is_gone_ends_by_itself(inputs, tmp_path):
    out = tmp_path / "out"
    job = plan(inputs, out, RenderConfig(**{**CONFIG.__dict__, "variants": 40}))
    root = Path(__file__).parents[2]
    command = [sys.executable, "-m", "sim1.render.worker", str(job.folder), str(out), "1"]
    worker = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, cwd=root
    )
    assert json.loads(worker.stdout.readline()) == {"device": "cpu"}
    worker.stdin.write("".join(Order(clip=clip.key, pictures=(("head", 0),)).line() for clip in job.clips))
    worker.stdin.close()
    worker.stdout.close()  # as the system does with what a killed parent held
    assert worker.wait(timeout=60) != 0
    assert len(list(out.rglob("*.png"))) < 5
    assert not list(out.rglob("*.part"))


@pytest.mark.parametrize("setting", [{"rate_hz": 7}, {"seed": -1}, {"seed": 2**31}, {"cameras": ()}], ids=str)
def test_settings_that_make_no_sense_are_refused_before_any_work(setting):
    with pytest.raises(ValidationError, match=next(iter(setting))):
        RenderConfig(**setting)


def test_every_rate_that_divides_that_of_the_states_is_a_setting():
    assert [rate for rate in range(1, 31) if RATE_HZ % rate == 0] == list(
        get_args(get_type_hints(RenderConfig)["rate_hz"])
    )


def test_an_unknown_camera_is_refused_with_those_that_there_are(inputs, tmp_path):
    with pytest.raises(BadInput, match="no camera tail; it has head, left_wrist, right_wrist"):
        render(inputs, tmp_path / "out", RenderConfig(cameras=("tail",)))


def test_an_episode_of_another_garment_is_refused(inputs, tmp_path):
    mesh = inputs["garment_mesh"]["towel"] / "mesh.npz"
    arrays = dict(np.load(mesh))
    arrays["rest_m"] = np.vstack([arrays["rest_m"], [[0, 0, 1]]])
    np.savez(mesh, **arrays)
    with pytest.raises(BadInput, match="144 garment vertices"):
        render(inputs, tmp_path / "out")


def test_a_missing_texture_is_named(inputs, tmp_path):
    (inputs["garment_mesh"]["towel"] / "texture.png").unlink()
    with pytest.raises(BadInput, match=r"texture\.png"):
        render(inputs, tmp_path / "out")


def test_no_accepted_trajectory_gives_an_empty_artifact_that_its_check_refuses(inputs, tmp_path):
    empty = tmp_path / "empty"
    empty.mkdir()
    facts = render({**inputs, "valid_trajectories": {"towel": empty}}, tmp_path / "out")
    assert facts["frames"] == 0
    assert [finding.name for finding in check_rendered_episodes(tmp_path / "out") if not finding.passed] == [
        "clips_present"
    ]
