"""Settings that a garment cannot follow are told with what to do; what the card says of looks is counted."""

import json

import pytest
from pydantic import ValidationError
from rendered_towel import LOOK, ROBOT, VERTICES, write_rendered

from sim1.dataset.stage import DatasetConfig, dataset
from sim1.stage import BadInput


@pytest.mark.parametrize(
    "setting",
    [{"keypoint_count": 0}, {"crf": -1}, {"crf": 64}, {"keyframe_interval": 0}, {"keyframe_interval": 1001}],
    ids=str,
)
def test_settings_that_make_no_sense_are_refused_before_any_work(setting):
    with pytest.raises(ValidationError, match=next(iter(setting))):
        DatasetConfig(**setting)


def test_more_keypoints_than_a_mesh_has_vertices_are_refused_with_garment_mesh_setting_and_remedy(tmp_path):
    artifact = write_rendered(tmp_path / "towel")
    with pytest.raises(BadInput) as said:
        dataset(
            {"robot": ROBOT, "rendered_episodes": {"towel": artifact}},
            tmp_path / "out",
            DatasetConfig(keypoint_count=VERTICES + 1),
        )
    assert str(said.value) == (
        f"{artifact}/garment.npz: the mesh of towel has 40 vertices, setting keypoint_count of stage dataset wants "
        "41; set it to 40 at most, or make garment_mesh finer"
    )
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("turns_rad", "count", "elevation"),
    [
        ((0.01, 0.01), 1, "is the same in all of them, +0.6° from where the scene has it"),
        ((-0.02, 0.07), 2, "varies by -1.1° to +4.0° from where the scene has it"),
    ],
)
def test_the_card_says_how_many_appearances_there_are_and_whether_the_camera_moves_between_them(
    tmp_path, turns_rad, count, elevation
):
    artifact = write_rendered(tmp_path / "towel", frame_counts=(10, 10))
    for path, turn_rad in zip(sorted(artifact.glob("episodes/*/v0/appearance.json")), turns_rad, strict=True):
        about = json.loads(path.read_text())
        path.write_text(json.dumps({**about, "appearance": {**LOOK, "elevation_offset_rad": turn_rad}}))
    (tmp_path / "out").mkdir()
    dataset({"robot": ROBOT, "rendered_episodes": {"towel": artifact}}, tmp_path / "out", DatasetConfig())
    card = " ".join((tmp_path / "out" / "README.md").read_text().split())
    assert f"The 2 episodes show {count} of them, with 1 tables and 1 rooms and their light;" in card
    assert f"the head camera's elevation {elevation}." in card
