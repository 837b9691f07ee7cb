"""What is rendered and what of an earlier rendering is kept: frames that show what they would show again, and no others."""

import json
import re
import shutil
from dataclasses import replace
from importlib.metadata import version

import numpy as np
import pytest
from planned_towel import CONFIG, FRAME, plan, png, with_frames
from towel_cell import write_inputs

from sim1.episode import read_episode, write_episode
from sim1.render.appearance_file import note_device, read_about
from sim1.render.job import Job
from sim1.render.plan import drawn
from sim1.render.stage import RenderConfig


@pytest.fixture
def inputs(tmp_path):
    return write_inputs(tmp_path)


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


@pytest.mark.parametrize("shared", [1, 3])
def test_shared_looks_are_all_that_is_seen_and_are_the_same_for_other_trajectories(inputs, tmp_path, shared):
    many = RenderConfig(**{**CONFIG.__dict__, "variants": 24, "shared_looks": shared})
    choose = drawn(inputs["appearance"]["towel"], "towel", many, {})
    texture = np.full((1, 3), 0.5)
    first, second = choose("0000", texture), choose("0001", texture)
    seen = [look for number, look in enumerate(first) if look not in first[:number]]
    assert len(seen) == shared
    assert all(look in seen for look in second)
    assert shared == 1 or second != first
    hidden = drawn(inputs["appearance"]["towel"], "towel", many, {("0001", 5): 1})
    unlike = [old != new for old, new in zip(second, hidden("0001", texture), strict=True)]
    assert unlike == [look == second[5] for look in second]  # drawn anew for all that share it, and for no other
    assert [old != new for old, new in zip(first, hidden("0000", texture), strict=True)] == [
        look == second[5] for look in first
    ]
    own = drawn(inputs["appearance"]["towel"], "towel", CONFIG, {})
    assert not any(look in own("0000", texture) for look in own("0001", texture))


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


def test_garments_whose_episodes_are_numbered_alike_have_noise_of_their_own_and_keep_no_frame_of_each_other(
    inputs, tmp_path
):
    towel = plan(inputs, tmp_path / "out", CONFIG)
    frames = with_frames(tmp_path / "out", towel)
    shirt = plan(inputs, tmp_path / "out", CONFIG, garment="tshirt")
    assert not any(path.exists() for path in frames.values())
    before, after = ({job.picture_seed(job.clips[0], "head", frame) for frame in range(4)} for job in (towel, shirt))
    assert before.isdisjoint(after)
    assert Job.read(shirt.folder).picture_seed(shirt.clips[0], "head", 1) in after  # as Blender's processes know it


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
