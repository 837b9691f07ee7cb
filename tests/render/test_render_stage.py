"""Trajectories become frames: in step with the states, repeatable, resumable."""

import io
import json
import re
import shutil
import subprocess
import sys
import time
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import get_args, get_type_hints

import numpy as np
import pytest
from PIL import Image
from pydantic import ValidationError
from towel_cell import write_inputs

from sim1.episode import RATE_HZ, read_episode, write_episode
from sim1.progress import listening
from sim1.render.appearance_file import note_device, read_about
from sim1.render.blender import NO_OPENGL, BlenderFailed
from sim1.render.plan import drawn, plan_job
from sim1.render.stage import RenderConfig, check_rendered_episodes, check_source_appearance, rendered_episodes
from sim1.stage import BadInput

CONFIG = RenderConfig(width=48, height=36, samples=2, rate_hz=15, variants=2, threads=1, device="cpu")


def png(width: int, height: int, gray: int = 0) -> bytes:
    """A picture of noise, or of one grey."""
    pixels = (
        np.random.default_rng(0).integers(60, 200, (height, width, 3))
        if not gray
        else np.full((height, width, 3), gray)
    )
    file = io.BytesIO()
    Image.fromarray(pixels.astype(np.uint8)).save(file, format="PNG")
    return file.getvalue()


FRAME = png(48, 36)  # stands for one that was rendered


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


def test_the_same_seed_gives_the_same_bytes(inputs, tmp_path):
    short = RenderConfig(
        width=48, height=36, samples=2, rate_hz=10, variants=1, max_episodes=1, threads=1, device="cpu"
    )
    render(inputs, tmp_path / "a", short)
    render(inputs, tmp_path / "b", short)
    assert contents(tmp_path / "a") == contents(tmp_path / "b")


def plan(inputs, out: Path, config: RenderConfig):
    """What would be rendered, without Blender."""
    out.mkdir(exist_ok=True)
    return plan_job(
        trajectories=inputs["valid_trajectories"]["towel"],
        mesh=inputs["garment_mesh"]["towel"],
        scene=inputs["scene"]["towel"],
        choice=drawn(inputs["appearance"]["towel"], "towel", config),
        garment="towel",
        out=out,
        folder=out.with_suffix(".job"),
        config=config,
    )


def test_another_seed_gives_another_look_and_removes_the_frames_of_the_old_one(inputs, tmp_path):
    plan(inputs, tmp_path / "out", CONFIG)
    frame = tmp_path / "out/episodes/0000/v1/head/000000.png"
    frame.parent.mkdir()
    frame.write_bytes(FRAME)
    before = (tmp_path / "out/episodes/0000/v1/appearance.json").read_text()
    plan(inputs, tmp_path / "out", CONFIG)
    assert frame.exists()
    plan(inputs, tmp_path / "out", RenderConfig(**{**CONFIG.__dict__, "seed": 1}))
    assert not frame.exists()
    assert (tmp_path / "out/episodes/0000/v1/appearance.json").read_text() != before


def with_frames(out: Path, job) -> dict[str, Path]:
    """A stand-in for the first frame of every clip: clip -> file."""
    files = {}
    for clip in job.clips:
        files[clip.key] = job.frame_path(out, clip, "head", 0)
        files[clip.key].parent.mkdir(parents=True, exist_ok=True)
        files[clip.key].write_bytes(FRAME)
    return files


def test_a_changed_fabric_costs_the_frames_that_show_it_and_no_others(inputs, tmp_path):
    many = RenderConfig(**{**CONFIG.__dict__, "variants": 24, "scanned_share": 0.5})
    out = tmp_path / "out"
    job = plan(inputs, out, many)
    frames = with_frames(out, job)
    shown = {clip.key: clip.appearance.fabric.name for clip in job.clips}
    changed = next(name for name in shown.values() if name != "scanned")
    file = inputs["appearance"]["towel"] / "fabrics.yaml"
    head, name, entry = file.read_text().partition(f"  {changed}:")
    file.write_text(head + name + re.sub(r"sheen: .*", "sheen: 0.9", entry, count=1))
    plan(inputs, out, many)
    assert {key for key, path in frames.items() if not path.exists()} == {
        key for key, name in shown.items() if name == changed
    }


@pytest.mark.parametrize(
    "change",
    [
        {"samples": 3}, {"engine": "workbench"}, {"width": 50}, {"seed": 7}, {"denoise": False}, {"rate_hz": 5},
        {"cameras": ("head", "left_wrist")}, {"device": "auto"},
    ],
    ids=str,
)  # fmt: skip
def test_frames_that_other_settings_made_are_not_kept(inputs, tmp_path, change):
    out = tmp_path / "out"
    config = RenderConfig(**{**CONFIG.__dict__, "scanned_share": 1.0})
    frames = with_frames(out, plan(inputs, out, config))
    plan(inputs, out, RenderConfig(**{**config.__dict__, **change}))
    assert not any(path.exists() for path in frames.values())


@pytest.mark.parametrize(
    "damaged", [b"", FRAME[:200], png(50, 36), png(48, 36, gray=1), png(48, 36, gray=99)],
    ids=["empty", "cut short", "of another size", "black", "of one colour"],
)  # fmt: skip
def test_frames_that_the_check_would_refuse_are_rendered_again(inputs, tmp_path, damaged):
    out = tmp_path / "out"
    first, second = with_frames(out, plan(inputs, out, CONFIG)).values()
    second.write_bytes(damaged)
    plan(inputs, out, CONFIG)
    assert first.exists()
    assert not second.exists()


def test_frames_of_a_robot_in_another_colour_are_not_kept(inputs, tmp_path):
    out = tmp_path / "out"
    frames = with_frames(out, plan(inputs, out, CONFIG))
    urdf = inputs["scene"]["towel"] / "robot.urdf"
    text = urdf.read_text()
    plan(inputs, out, CONFIG)
    assert all(path.exists() for path in frames.values())
    urdf.write_text(re.sub(r'rgba="[^"]*"', 'rgba="0.1 0.9 0.1 1"', text, count=1))
    plan(inputs, out, CONFIG)
    assert not any(path.exists() for path in frames.values())


def test_frames_of_another_blender_are_not_kept_and_those_of_another_device_are(inputs, tmp_path, monkeypatch):
    out = tmp_path / "out"
    frames = with_frames(out, plan(inputs, out, CONFIG))
    clip = out / "episodes/0000/v0"
    note_device(clip, "gpu")
    note_device(clip, "cpu")
    plan(inputs, out, CONFIG)
    assert all(path.exists() for path in frames.values())
    assert read_about(clip / "appearance.json")["rendered_on"] == ["cpu", "gpu"]
    monkeypatch.setattr("sim1.render.plan.version", lambda _: "0.0")
    plan(inputs, out, CONFIG)
    assert not any(path.exists() for path in frames.values())
    assert read_about(clip / "appearance.json")["rendered_on"] == []


def test_only_episodes_with_missing_frames_are_given_to_blender(inputs, tmp_path):
    out = tmp_path / "out"
    trajectories = inputs["valid_trajectories"]["towel"] / "episodes"
    shutil.copytree(trajectories / "0000", trajectories / "0001")
    job = plan(inputs, out, CONFIG)
    assert {path.name for path in job.folder.glob("motion_*")} == {"motion_0000.npz", "motion_0001.npz"}
    for clip, camera, frame in job.frames():
        path = job.frame_path(out, clip, camera, frame)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(FRAME)
    job.frame_path(out, job.clips[-1], "head", 2).unlink()
    shutil.rmtree(job.folder)
    plan(inputs, out, CONFIG)
    assert {path.name for path in job.folder.glob("*_*")} == {"motion_0001.npz", "cameras_0001_v1.npz"}


def test_each_picture_has_noise_of_its_own_that_is_the_same_at_another_rate_and_in_another_look(inputs, tmp_path):
    fast = plan(inputs, tmp_path / "fast", CONFIG)
    slow = plan(inputs, tmp_path / "slow", RenderConfig(**{**CONFIG.__dict__, "rate_hz": 5}))
    other = plan(inputs, tmp_path / "other", RenderConfig(**{**CONFIG.__dict__, "seed": 1}))
    clip, again = fast.clips
    seeds = [fast.picture_seed(clip, camera, frame) for camera in ("head", "left_wrist") for frame in range(4)]
    assert len(set(seeds)) == 8
    assert all(0 <= seed < 2**31 for seed in seeds)
    assert fast.picture_seed(again, "head", 3) == seeds[3]
    assert slow.picture_seed(slow.clips[0], "head", 1) == seeds[3]  # state 6
    assert other.picture_seed(other.clips[0], "head", 3) != seeds[3]


def test_what_an_earlier_rendering_left_of_other_episodes_and_appearances_is_removed(inputs, tmp_path):
    out = tmp_path / "out"
    with_frames(out, plan(inputs, out, RenderConfig(**{**CONFIG.__dict__, "variants": 3})))
    (out / "episodes/0007/v0").mkdir(parents=True)
    plan(inputs, out, CONFIG)
    assert sorted(path.relative_to(out).as_posix() for path in out.glob("episodes/*/v*")) == [
        "episodes/0000/v0",
        "episodes/0000/v1",
    ]
    assert not (out / "episodes/0007").exists()


def test_what_was_drawn_is_recorded_by_name(inputs, tmp_path):
    out = tmp_path / "out"
    job = plan(inputs, out, CONFIG)
    about = json.loads((out / "episodes/0000/v1/appearance.json").read_text())
    look = job.clips[1].appearance
    assert about["schema"] == "sim1.appearance/3"
    assert (about["engine"], about["view_transform"]) == ("cycles", "AgX")
    assert about["blender"] == version("bpy")
    recorded = about["appearance"]
    assert (recorded["fabric"]["name"], recorded["table"]["name"], recorded["room"]["name"]) == (
        look.fabric.name,
        look.table.name,
        look.room.name,
    )
    assert recorded["room"]["name"].count("-") == 2


def test_the_preview_engine_gives_the_same_frames_twice_and_shows_the_garment(inputs, tmp_path):
    config = RenderConfig(**{**CONFIG.__dict__, "engine": "workbench", "scanned_share": 1.0, "variants": 1})
    try:
        render(inputs, tmp_path / "a", config)
    except BlenderFailed as error:
        if NO_OPENGL in str(error):
            pytest.skip(NO_OPENGL)
        raise
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


def test_cloth_that_rests_in_the_table_top_by_a_contact_radius_is_drawn_above_it(inputs, tmp_path):
    arrays = plan(inputs, tmp_path / "out", CONFIG).arrays()
    assert -0.005 < arrays["table_vertices"][:, 2].max() < -0.002


def test_frames_of_another_motion_are_not_taken_for_these(inputs, tmp_path):
    plan(inputs, tmp_path / "out", CONFIG)
    frame = tmp_path / "out/episodes/0000/v1/head/000000.png"
    frame.parent.mkdir()
    frame.write_bytes(FRAME)
    source = inputs["valid_trajectories"]["towel"] / "episodes" / "0000"
    old = read_episode(source)
    moved = old.garment_m.copy()
    moved[4, 5, 2] += 1e-3  # frame 4 is shown at 15 Hz
    write_episode(source, replace(old, garment_m=moved))
    plan(inputs, tmp_path / "out", CONFIG)
    assert not frame.exists()


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
    job = plan(inputs, out, RenderConfig(**{**CONFIG.__dict__, "variants": 40})).folder
    root = Path(__file__).parents[2]
    command = [sys.executable, "-m", "sim1.render.worker", str(job), str(out)]
    worker = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, cwd=root)
    assert json.loads(worker.stdout.readline()) == {"done": 0, "total": 160, "what": "frames"}
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
