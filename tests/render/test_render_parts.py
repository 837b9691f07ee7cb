"""The pieces of rendering, without Blender."""

import json
import re
import shutil

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from towel_cell import URDF, episode, looking_at_origin, towel

from sim1.episode import write_episode
from sim1.render.cameras import project, raised
from sim1.render.check import check_frames
from sim1.render.robot_visuals import link_motion, part_poses, robot_parts
from sim1.robot.kinematics import Arm
from sim1.stage import BadInput


@given(azimuth=st.floats(-3.1, 3.1), elevation=st.floats(0.3, 1.2), change=st.floats(-0.2, 0.2))
def test_raising_a_camera_changes_its_elevation_alone(azimuth, elevation, change):
    def eye(angle):
        return 0.9 * np.array([np.cos(azimuth) * np.cos(angle), np.sin(azimuth) * np.cos(angle), np.sin(angle)])

    np.testing.assert_allclose(
        raised(looking_at_origin(tuple(eye(elevation))), change),
        looking_at_origin(tuple(eye(elevation + change))),
        atol=1e-9,
    )


def test_a_camera_above_the_middle_of_the_table_has_no_elevation_axis():
    pose = np.eye(4)
    pose[2, 3] = 1.0
    with pytest.raises(BadInput, match=r"scene\.json: camera head at \(0, 0, 1\) m stands straight above .* or move"):
        raised(pose, 0.1, what="scene.json: camera head")
    np.testing.assert_array_equal(raised(pose, 0.0), pose)


def test_points_fall_where_a_pinhole_puts_them():
    pose = looking_at_origin((0.0, -2.0, 0.0))
    pixels, depth = project(
        np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.25]]), camera_to_world=pose, fy_over_height=1.0, width=80, height=60
    )
    np.testing.assert_allclose(depth, 2.0)
    np.testing.assert_allclose(pixels, [[40.0, 30.0], [40.0 + 60 * 0.25, 30.0 - 60 * 0.125]])


def test_the_fingers_of_the_drawn_robot_open_with_the_gripper():
    arm = Arm.from_urdf(URDF)
    parts = robot_parts(arm)
    bases = {"left": np.eye(4), "right": np.eye(4)}
    motion = link_motion(arm, bases, joints_rad=np.zeros((2, 2, 6)), openness=np.array([[0.0, 0.0], [1.0, 0.0]]))
    poses = part_poses(parts, motion)
    assert poses.shape == (2, len(parts), 4, 4)
    moved = {
        (part.arm, part.link)
        for part, change in zip(parts, np.abs(poses[1] - poses[0]).max(axis=(1, 2)))
        if change > 1e-9
    }
    prismatic = {joint.child for joint in arm.robot.joints.values() if joint.kind == "prismatic"}
    assert len(prismatic) == 2
    assert moved == {(0, link) for link in prismatic}


@pytest.fixture
def artifact(tmp_path):
    """A hand-made artifact: a red square where the towel is, on grey noise."""
    camera = looking_at_origin((-0.45, 0.0, 0.8))
    folder = tmp_path / "episodes" / "0000"
    np.savez(tmp_path / "garment.npz", faces=towel()[1], rest_m=towel()[0])
    write_episode(folder, episode(4))
    about = {
        "stride": 2,
        "rate_hz": 15,
        "appearance": {part: {"name": f"{part}_name"} for part in ("fabric", "table", "room")},
        "cameras": {
            "head": {"width": 64, "height": 48, "fy_px": 42.0, "camera_to_world": camera.tolist(), "moves": False}
        },
    }
    (folder / "v0" / "head").mkdir(parents=True)
    (folder / "v0" / "appearance.json").write_text(json.dumps(about))
    image = np.random.default_rng(0).integers(90, 130, (48, 64, 3)).astype(np.uint8)
    pixels, _ = project(towel()[0], camera_to_world=camera, fy_over_height=42 / 48, width=64, height=48)
    left, top = pixels.min(axis=0).astype(int)
    right, bottom = pixels.max(axis=0).astype(int) + 1
    image[top:bottom, left:right] = (200, 40, 30)
    for frame in range(2):
        Image.fromarray(image).save(folder / "v0" / "head" / f"{frame:06d}.png")
    return tmp_path


def failures(artifact) -> list[str]:
    return [finding.name for finding in check_frames(artifact) if not finding.passed]


def test_a_good_artifact_passes(artifact):
    assert failures(artifact) == []


def damage(name: str, artifact):
    frames = artifact / "episodes/0000/v0/head"
    match name:
        case "all frames are missing":
            shutil.rmtree(frames)
        case "a frame is missing":
            (frames / "000001.png").unlink()
        case "a frame is cut off":
            (frames / "000001.png").write_bytes((frames / "000001.png").read_bytes()[:300])
        case "a frame has another size":
            Image.open(frames / "000001.png").resize((32, 24)).save(frames / "000001.png")
        case "a frame is black":
            Image.new("RGB", (64, 48)).save(frames / "000001.png")
        case "a frame has one colour":
            Image.new("RGB", (64, 48), (100, 100, 100)).save(frames / "000001.png")
        case "the garment is not there":
            Image.fromarray(np.random.default_rng(1).integers(90, 130, (48, 64, 3)).astype(np.uint8)).save(
                frames / "000000.png"
            )
        case "the garment's faces are gone":
            (artifact / "garment.npz").unlink()
        case "the garment's faces are cut off":
            (artifact / "garment.npz").write_bytes((artifact / "garment.npz").read_bytes()[:200])
        case "the states are damaged":
            (artifact / "episodes/0000/episode.npz").write_bytes(b"PK")


def test_a_garment_that_is_not_seen_is_told_with_look_value_limit_and_remedy(artifact):
    damage("the garment is not there", artifact)
    (failed,) = [finding for finding in check_frames(artifact) if not finding.passed]
    assert re.search(
        r"0000/v0/head: \d\.\d \(fabric fabric_name on table table_name in room room_name\); at least 8 of 255 grey levels .* make "
        r"fabric and table differ more in data/appearance",
        failed.detail,
    )


@pytest.mark.parametrize(
    ("what", "finding"),
    [
        ("a frame is missing", "frames_match_states"),
        ("all frames are missing", "clips_present"),
        ("a frame is cut off", "frames_readable"),
        ("a frame has another size", "frames_readable"),
        ("a frame is black", "frames_lit"),
        ("a frame has one colour", "frames_lit"),
        ("the garment is not there", "garment_visible"),
        ("the garment's faces are gone", "garment_readable"),
        ("the garment's faces are cut off", "garment_readable"),
        ("the states are damaged", "frames_match_states"),
    ],
)
def test_damage_is_found(artifact, what, finding):
    damage(what, artifact)
    assert finding in failures(artifact)
