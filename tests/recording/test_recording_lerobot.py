"""Joints of a LeRobot dataset become gripper frames: where the arm's own kinematics puts them, at the dataset's time stamps."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from lab_files import change_import, lab_folder, write_c3d
from scipy.spatial.transform import Rotation
from swinging import swing

from sim1.episode import ARMS
from sim1.recording.importing.lerobot import read_lerobot_drives
from sim1.recording.importing.write import import_bundle
from sim1.robot.calibration import place_arms, read_arms
from sim1.robot.kinematics import Arm
from sim1.stage import BadInput

ROBOT = Path(__file__).parents[2] / "data" / "robot"
NAMES = [name for arm in ARMS for name in (*(f"{arm}_joint_{j + 1}_rad" for j in range(6)), f"{arm}_openness")]
FRAMES, RATE = 140, 30.0


def joints(episode: int) -> np.ndarray:
    """States (T, 14) of a slow motion around the home pose, one gripper closing."""
    home = np.array(read_arms(ROBOT).home_rad)
    phase = np.sin(np.linspace(0, 2, FRAMES))[:, None] * (0.1 + 0.05 * episode)
    closing = np.linspace(1, 0, FRAMES)[:, None]
    return np.concatenate([home + phase, closing, home - phase, 0 * closing], axis=1).astype(np.float32)


def dataset_folder(folder: Path, *, names=NAMES, version="v3.0", nest=False) -> Path:
    """Two episodes in one file, as version 3 lays them out; the second was measured a little off its command."""
    (folder / "meta").mkdir(parents=True)
    (folder / "data/chunk-000").mkdir(parents=True)
    feature = {"dtype": "float32", "shape": [len(names)], "names": {"motors": names} if nest else names}
    info = {
        "codebase_version": version,
        "total_episodes": 2,
        "features": {"action": feature, "observation.state": feature},
    }
    (folder / "meta/info.json").write_text(json.dumps(info))
    parts = [
        pd.DataFrame(
            {
                "episode_index": episode,
                "timestamp": (np.arange(FRAMES) / RATE).astype(np.float32),
                "action": list(joints(episode)),
                "observation.state": list(
                    joints(episode) + np.float32(0.01 * episode) * np.array([1, 0, 1, 0, 1, 0, 0] * 2, np.float32)
                ),
            }
        )
        for episode in range(2)
    ]
    pd.concat(parts).to_parquet(folder / "data/chunk-000/file-000.parquet")
    return folder


def by_the_arm(states: np.ndarray) -> dict[str, np.ndarray]:
    arms = read_arms(ROBOT)
    arm = Arm.from_urdf(ROBOT / arms.urdf)
    placed = place_arms(ROBOT, arm, arms).base_to_world
    return {side: placed[side] @ arm.forward(states[:, 7 * k : 7 * k + 6].astype(float)) for k, side in enumerate(ARMS)}


@pytest.mark.parametrize("nest", [False, True])
def test_gripper_frames_are_where_the_arm_puts_them(tmp_path, nest):
    drives = read_lerobot_drives(dataset_folder(tmp_path / "d", nest=nest), 1, ROBOT).tracks
    for side, pose in by_the_arm(joints(1)).items():
        np.testing.assert_allclose(drives[side].position_m, pose[:, :3, 3], atol=1e-9)
        turned = Rotation.from_quat(drives[side].rotation_wxyz, scalar_first=True).as_matrix()
        np.testing.assert_allclose(turned, pose[:, :3, :3], atol=1e-9)
        np.testing.assert_allclose(drives[side].time_s, np.arange(FRAMES) / RATE, atol=1e-6)
    np.testing.assert_allclose(drives["left"].openness, np.linspace(1, 0, FRAMES), atol=1e-6)


def test_measured_joints_are_taken_where_one_asks_for_them(tmp_path):
    folder = dataset_folder(tmp_path / "d")
    commanded, measured = (
        read_lerobot_drives(folder, 1, ROBOT, use).tracks["left"] for use in ("action", "observation.state")
    )
    assert np.abs(commanded.position_m - measured.position_m).max() > 1e-3
    same = (read_lerobot_drives(folder, 0, ROBOT, use).tracks["left"] for use in ("action", "observation.state"))
    np.testing.assert_array_equal(*(track.position_m for track in same))


def test_a_dataset_that_lerobot_itself_wrote_is_read(tmp_path):
    from sim1.dataset.quiet import quiet_libraries

    with quiet_libraries():
        from lerobot.datasets.lerobot_dataset import LeRobotDataset

        feature = {"dtype": "float32", "shape": (14,), "names": NAMES}
        features = {"action": feature, "observation.state": dict(feature)}
        writer = LeRobotDataset.create(
            repo_id="lab", fps=30, features=features, root=tmp_path / "d", robot_type="arx_x5_dual"
        )
        for episode in range(2):
            for row in joints(episode):
                writer.add_frame({"action": row, "observation.state": row, "task": "swing"})
            writer.save_episode()
        writer.finalize()
    drives = read_lerobot_drives(tmp_path / "d", 1, ROBOT).tracks
    np.testing.assert_allclose(drives["right"].position_m, by_the_arm(joints(1))["right"][:, :3, 3], atol=1e-9)


def test_a_bundle_takes_its_drives_from_an_episode_and_its_markers_from_the_cameras(tmp_path):
    recording = swing("swing_a")
    folder = lab_folder(tmp_path / "lab", recording)
    write_c3d(folder / "cameras.c3d", recording)
    dataset = dataset_folder(folder / "dataset")

    def edit(content):
        part = content["recordings"]["swing_a"]
        part["drives"] = {"kind": "lerobot", "episode": 1, "shift_s": -0.05}
        part["markers"] = {"kind": "c3d", "file": "cameras.c3d"}
        part["starts"] = "moving"  # as the arms of this episode do
        part["holds"] = [{"drive": "left", "vertices": [0, 1]}, {"drive": "right", "vertices": [4, 5]}]

    change_import(folder, edit)
    [back] = import_bundle("lerobot", [dataset], tmp_path / "bundle", robot=ROBOT).bundle.recordings
    assert sorted(back.drives) == ["left", "right"]
    assert back.drives["left"].time_s[0] == pytest.approx(-0.05)
    np.testing.assert_allclose(back.drives["left"].position_m, by_the_arm(joints(1))["left"][:, :3, 3], atol=1e-9)
    assert [hold.places_m for hold in back.holds] == [None, None]
    assert back.holds[0].to_s == pytest.approx(back.drives["left"].time_s[-1])


def test_what_is_no_such_dataset_is_refused_by_name(tmp_path):
    good = dataset_folder(tmp_path / "good")
    for episode, words in ((7, "no episode 7"), (-1, "no episode -1")):
        with pytest.raises(BadInput, match=words):
            read_lerobot_drives(good, episode, ROBOT)
    with pytest.raises(BadInput, match=r"info\.json"):
        read_lerobot_drives(tmp_path / "nowhere", 0, ROBOT)
    with pytest.raises(BadInput, match=r"'v2\.1'; convert"):
        read_lerobot_drives(dataset_folder(tmp_path / "old", version="v2.1"), 0, ROBOT)
    names = [name.replace("left_joint_3", "left_elbow") for name in NAMES]
    with pytest.raises(BadInput, match="no 'left_joint_3_rad'"):
        read_lerobot_drives(dataset_folder(tmp_path / "renamed", names=names), 0, ROBOT)
    with pytest.raises(BadInput, match="expected left_joint_1_rad"):
        read_lerobot_drives(dataset_folder(tmp_path / "other", names=[f"motor_{k}" for k in range(14)]), 0, ROBOT)
    with pytest.raises(BadInput, match=r"no features\.effort"):
        read_lerobot_drives(good, 0, ROBOT, "effort")
    (good / "data/chunk-000/file-000.parquet").write_bytes(b"PAR1")
    with pytest.raises(BadInput, match=r"file-000\.parquet"):
        read_lerobot_drives(good, 0, ROBOT)
    degrees = dataset_folder(tmp_path / "degrees")
    table = pd.read_parquet(degrees / "data/chunk-000/file-000.parquet")
    table["action"] = table["action"].map(np.rad2deg)
    table.to_parquet(degrees / "data/chunk-000/file-000.parquet")
    with pytest.raises(BadInput, match=r"file-000\.parquet: row 0 \(episode 0, frame 0\): action .*are these degrees"):
        read_lerobot_drives(degrees, 0, ROBOT)


def change_frame(dataset: Path, row: int, edit, column: str = "action") -> None:
    """Change what stands in one row of the dataset's file; episode 1 begins in row 140."""
    path = dataset / "data/chunk-000/file-000.parquet"
    table = pd.read_parquet(path).reset_index(drop=True)
    cells = list(table[column])
    cells[row] = edit(cells[row])
    table.assign(**{column: cells}).to_parquet(path)


def instead(name: str, value: float):
    return lambda values: np.where(np.array(NAMES) == name, np.float32(value), values)


FRAME_FAULTS = {
    "a joint that is NaN": (
        "observation.state",
        instead("right_joint_2_rad", np.nan),
        "observation.state right_joint_2_rad is nan; expected a finite number.*repair",
    ),
    "an openness that is infinite": ("action", instead("left_openness", np.inf), "action left_openness is inf"),
    "an openness in per cent": (
        "action",
        instead("left_openness", 57),
        r"action left_openness is 57; expected 0 \(closed\) to 1 \(open\).*divide by 100",
    ),
    "an openness below closed": ("action", instead("right_openness", -2e-4), "action right_openness is -0.0002"),
    "a value too few": ("action", lambda values: values[:-1], "action has 13 values for 14 names"),
    "a time that is NaN": ("timestamp", lambda _: np.nan, "timestamp is nan"),
    "a clock that runs back": ("timestamp", lambda _: 0.1, "drive 'left': the clock runs back from .* to 0.1"),
    "an arm that jumps": ("action", instead("left_joint_1_rad", 1.2), "drive 'left': the drive jumps"),
}


@pytest.mark.parametrize("fault", FRAME_FAULTS)
def test_a_fault_of_a_frame_is_named_by_file_row_episode_and_frame(tmp_path, fault):
    column, edit, words = FRAME_FAULTS[fault]
    dataset = dataset_folder(tmp_path / "d")
    change_frame(dataset, FRAMES + 20, edit, column)
    use = "action" if column == "timestamp" else column
    said = rf"d/data/chunk-000/file-000\.parquet: row 160 \(episode 1, frame 20\): {words}"
    with pytest.raises(BadInput, match=said):
        read_lerobot_drives(dataset, 1, ROBOT, use)
    assert read_lerobot_drives(dataset, 0, ROBOT, use).tracks.keys() == {"left", "right"}


def test_an_openness_past_its_ends_by_rounding_is_moved_onto_them(tmp_path):
    dataset = dataset_folder(tmp_path / "d")
    change_frame(dataset, FRAMES, instead("left_openness", 1 + 9e-5))
    change_frame(dataset, FRAMES + 9, instead("right_openness", -9e-5))
    tracks = read_lerobot_drives(dataset, 1, ROBOT).tracks
    assert (tracks["left"].openness[0], tracks["right"].openness[9]) == (1.0, 0.0)


def test_columns_of_another_kind_are_refused_by_the_name_of_their_file(tmp_path):
    for column, value in (("timestamp", "noon"), ("action", "home")):
        dataset = dataset_folder(tmp_path / column)
        path = dataset / "data/chunk-000/file-000.parquet"
        pd.read_parquet(path).assign(**{column: value}).to_parquet(path)
        with pytest.raises(BadInput, match=rf"{column}/data/chunk-000/file-000\.parquet: not readable .*{value}"):
            read_lerobot_drives(dataset, 0, ROBOT)
