"""Provenance says how each camera projects and where it stood: a known point lies where the numbers say."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from planned_towel import plan
from rendered_towel import write_rendered
from towel_cell import write_inputs

from sim1.dataset.camera_models import camera_model
from sim1.dataset.sources import CAMERA, read_clips
from sim1.episode import read_episode
from sim1.render.cameras import project, raised
from sim1.render.stage import RenderConfig
from sim1.robot.kinematics import Arm
from sim1.scene.description import read_scene
from sim1.stage import BadInput

CONFIG = RenderConfig(width=96, height=72, variants=2, cameras=("head", "left_wrist", "right_wrist"))


def seen_at(model: dict, point_m: np.ndarray) -> list[float]:
    """Pixel of a point in the world, by a matrix of intrinsics in the convention of OpenCV (x right, y down, z forward)."""
    intrinsics = np.array([[model["fx"], 0, model["cx"]], [0, model["fy"], model["cy"]], [0, 0, 1]])
    local = np.linalg.inv(model["camera_to_world"]) @ [*point_m, 1.0]
    pixel = intrinsics @ (np.diag([1, -1, -1]) @ local[:3])
    return (pixel[:2] / pixel[2]).tolist()


def test_a_point_beside_the_axis_is_seen_where_the_numbers_say(good):
    (model,) = json.loads(pd.read_parquet(good / "provenance.parquet")["cameras"][0]).values()
    # A metre above the table, 40 px per unit of slope: 0.2 m right and 0.1 m up in the picture.
    assert (model["width"], model["height"], model["cx"], model["cy"]) == (64, 48, 32.0, 24.0)
    assert seen_at(model, np.array([0.2, 0.1, 0.0])) == pytest.approx([40.0, 20.0])


@pytest.fixture(scope="module")
def planned(tmp_path_factory) -> tuple[dict, Path]:
    """Inputs of the rendering, and what it says of the cameras."""
    folder = tmp_path_factory.mktemp("cameras")
    inputs = write_inputs(folder)
    plan(inputs, folder / "out", CONFIG)
    return inputs, folder / "out"


def test_the_head_camera_is_told_where_the_appearance_has_raised_it(planned):
    inputs, out = planned
    scene, turns = read_scene(inputs["scene"]["towel"]), set()
    corner = np.array([0.25, -0.2, 0.004])
    for path in sorted(out.glob("episodes/0000/v*/appearance.json")):
        about = json.loads(path.read_text())
        model = camera_model("head", about["cameras"]["head"], scene)
        turn_rad = about["appearance"]["elevation_offset_rad"]
        turns.add(turn_rad)
        head = scene.cameras["head"]
        view = {"fy_over_height": head.fy_px / head.height, "width": 96, "height": 72}
        pixels, _ = project(corner[None], camera_to_world=raised(head.pose, turn_rad), **view)
        assert seen_at(model, corner) == pytest.approx(pixels[0].tolist(), abs=1e-4)
        assert "link" not in model
    assert len(turns) == 2


@pytest.mark.parametrize("arm", ["left", "right"])
def test_a_wrist_camera_is_told_by_the_link_that_carries_it(planned, arm):
    inputs, out = planned
    scene = read_scene(inputs["scene"]["towel"])
    about = json.loads((out / "episodes/0000/v0/appearance.json").read_text())
    model = camera_model(f"{arm}_wrist", about["cameras"][f"{arm}_wrist"], scene)
    joints_rad = read_episode(out / "episodes/0000").joints_rad[0, ("left", "right").index(arm)]
    link = Arm.from_urdf(scene.urdf).link_poses(joints_rad)[model["link"]]
    np.testing.assert_allclose(
        scene.base_to_world[arm] @ link @ model["camera_to_link"], model["camera_to_world"], atol=1e-8
    )
    assert model["moves"]


def test_a_wrist_camera_that_the_scene_has_not_is_named(planned):
    inputs, _ = planned
    scene = read_scene(inputs["scene"]["towel"])
    seen_by = {"width": 4, "height": 2, "fy_px": 3.0, "camera_to_world": np.eye(4).tolist(), "moves": True}
    with pytest.raises(BadInput, match=r"scene\.json: wrist_cameras has no middle_wrist"):
        camera_model("middle_wrist", seen_by, scene)


@pytest.mark.parametrize("name", CAMERA)
def test_a_camera_that_is_not_wholly_told_is_named_with_its_file(tmp_path, name):
    folder = write_rendered(tmp_path / "towel")
    path = sorted(folder.glob("episodes/*/v0/appearance.json"))[0]
    about = json.loads(path.read_text())
    del about["cameras"]["head"][name]
    path.write_text(json.dumps(about))
    with pytest.raises(BadInput, match=rf"appearance\.json: not a readable appearance \('{name}'\); render"):
        read_clips(folder, "towel")
