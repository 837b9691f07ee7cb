import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from sim1.robot import virtual_calibration
from sim1.robot.calibration import lay, place_arms, read_arms
from sim1.robot.kinematics import Arm
from sim1.robot.virtual_calibration import calibrate_virtually
from sim1.stage import BadInput

ROBOT = Path(__file__).parents[2] / "data" / "robot"
ARM = Arm.from_urdf(ROBOT / "robot.urdf")


@pytest.fixture
def robot(tmp_path):
    return Path(shutil.copytree(ROBOT, tmp_path / "robot"))


def edit(robot: Path, change) -> None:
    path = robot / "calibration.yaml"
    document = yaml.safe_load(path.read_text())
    change(document)
    path.write_text(yaml.safe_dump(document))


def test_a_rigid_motion_is_recovered_exactly_from_points_without_error():
    stream = np.random.default_rng(0)
    points = stream.normal(size=(6, 3))
    turn, shift = Rotation.random(random_state=1).as_matrix(), np.array([0.3, -0.1, 0.2])
    pose, rms_mm = lay(points, points @ turn.T + shift)
    np.testing.assert_allclose(pose[:3, :3], turn, atol=1e-9)
    np.testing.assert_allclose(pose[:3, 3], shift, atol=1e-9)
    assert rms_mm < 1e-6


def test_without_measurement_error_both_bases_come_out_where_they_stand(robot, monkeypatch):
    for name in ("ENCODER_RAD", "SURVEY_M", "BASE_OFFSET_M", "BASE_TURN_RAD"):
        monkeypatch.setattr(virtual_calibration, name, 0.0)
    calibrate_virtually(robot)
    arms = read_arms(robot)
    placement = place_arms(robot, ARM, arms)
    assert placement.between_arms_rms_mm < 0.2  # the search's own tolerance is 0.1 mm
    for name, pose in placement.base_to_world.items():
        np.testing.assert_allclose(pose[:3, 3], arms.nominal_base_m[name], atol=3e-4)
        np.testing.assert_allclose(pose[:3, :3], np.eye(3), atol=1e-3)


def test_the_shipped_calibration_is_virtual_and_submillimetre():
    placement = place_arms(ROBOT, ARM, read_arms(ROBOT))
    assert placement.virtual
    assert 0.05 < placement.between_arms_rms_mm < 1.0  # it has errors, and small ones


def test_the_shipped_calibration_is_what_the_model_of_a_calibration_makes(robot):
    calibrate_virtually(robot)
    shipped, again = (yaml.safe_load((folder / "calibration.yaml").read_text())["marks"] for folder in (ROBOT, robot))
    for one, other in zip(shipped, again, strict=True):
        for key in ("world_m", "left_rad", "right_rad"):
            np.testing.assert_allclose(one[key], other[key], atol=1e-4)


def test_a_survey_error_does_not_come_between_the_arms(robot):
    before = place_arms(robot, ARM, read_arms(robot)).base_to_world

    def shift(document):
        for mark in document["marks"]:
            mark["world_m"][0] += 0.01

    edit(robot, shift)
    after = place_arms(robot, ARM, read_arms(robot)).base_to_world
    between = [np.linalg.inv(pose["left"]) @ pose["right"] for pose in (before, after)]
    np.testing.assert_allclose(between[0], between[1], atol=1e-9)
    assert after["left"][0, 3] - before["left"][0, 3] == pytest.approx(0.01, abs=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d["marks"].__delitem__(slice(3, None)), "touch at least four marks"),
        (lambda d: d["marks"][2].update(left_rad=np.degrees(d["marks"][2]["left_rad"]).tolist()), "in degrees"),
        (lambda d: d["marks"][1]["world_m"].__setitem__(2, 0.05), "touch the marks again"),
        (lambda d: [m["world_m"].__setitem__(0, m["world_m"][0] + 0.3) for m in d["marks"]], "from its nominal place"),
        (lambda d: d["marks"][0].pop("right_rad"), r"marks.0.right_rad"),
        (lambda d: d.update(extra=1), "extra"),
    ],
)
def test_a_faulty_calibration_is_refused(robot, change, message):
    edit(robot, change)
    with pytest.raises(BadInput, match=message) as caught:
        place_arms(robot, ARM, read_arms(robot))
    assert "calibration.yaml" in str(caught.value)
