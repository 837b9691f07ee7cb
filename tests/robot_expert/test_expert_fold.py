"""The whole way on a small towel: settle, plan, grip by contact, fold, record, judge, replay, write."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
import yaml
from small_towel import TOWEL, place

import sim1.robot.demonstrations
from sim1.cloth.cell import Cell, SimulationBroke
from sim1.episode import read_episode, write_episode
from sim1.motion.replay import replay_commands
from sim1.robot.session import shortened
from sim1.robot.stage import SeedDemosConfig, check_seed_demos, seed_demos
from sim1.scene.description import read_scene, write_scene
from sim1.stage import BadInput


def test_a_small_towel_is_folded_by_finger_contact(artifact):
    out, facts = artifact
    assert facts["success_count"] == 1
    assert facts["largest_pad_slip_mm"] < 5.0
    assert facts["largest_crossing_count"] == 0
    episode = read_episode(out / "episodes" / f"{facts['attempt_count'] - 1:04d}")
    assert episode.about["success"]
    assert episode.about["figures"]["iou"] > 0.8
    assert episode.about["task_text"] == "fold the small towel"
    assert np.abs(np.diff(episode.time_s) - 1 / 30).max() < 1e-9


def test_all_blocking_checks_pass_and_the_replay_of_the_whole_run_is_equal_to_the_byte(artifact):
    out, _ = artifact
    failed = [finding for finding in check_seed_demos(out) if not finding.passed and finding.blocking]
    assert not failed, failed
    again = json.loads((out / "cell.json").read_text())["replay"]
    assert again["frame_count"] > 150
    assert again["largest_difference_m"] == 0.0


@pytest.mark.parametrize(
    ("falls_from_m", "complaint"),
    [
        (0.3, r"0\.1 s after .* still moves at 0\.\d+ m/s, at rest is below 0\.03; give it longer \(settle_s\)"),
        (-0.5, "slid off the table"),
    ],
)
def test_a_garment_that_does_not_come_to_rest_is_refused(inputs, tmp_path, falls_from_m, complaint):
    copied = shutil.copytree(inputs["scene"]["towel"], tmp_path / "scene")
    write_scene(copied, replace(read_scene(copied), garment_place=place((0.0, 0.0, falls_from_m))))
    config = SeedDemosConfig(substeps=2, iterations=1, settle_s=0.1)
    with pytest.raises(BadInput, match=complaint):
        seed_demos({**inputs, "scene": {"towel": copied}}, tmp_path, config)


@pytest.mark.parametrize("breaks_at", [1, 30])
def test_demonstrations_whose_simulation_breaks_fail_and_do_not_crash(inputs, tmp_path, monkeypatch, breaks_at):
    def step(cell, joints_rad, openness):
        steps(cell, joints_rad, openness)
        if cell.frame == breaks_at:
            raise SimulationBroke(cell.frame, 3, "vertex 3 flew away")

    steps, lying = Cell.step, (TOWEL.rest_m + np.array([0.0, 0.0, 0.002])).astype(np.float32)
    monkeypatch.setattr(Cell, "step", step)
    monkeypatch.setattr(sim1.robot.demonstrations, "settle", lambda cell, **limits: lying)
    config = SeedDemosConfig(demo_count=1, attempts=2, substeps=2, iterations=1)
    facts = seed_demos(inputs, tmp_path, config)
    assert [row["failure"] for row in facts["attempts"]] == ["simulation broke"] * 2
    findings = {finding.name: finding for finding in check_seed_demos(tmp_path)}
    assert findings["replay_reproduces_demonstration"].passed
    assert not findings["a_demonstration_succeeds"].passed


def test_an_episode_is_replayed_in_the_fabric_that_it_was_made_in(artifact, inputs, tmp_path):
    """Nothing of the calibration is asked: by now it may be another one."""
    out, _ = artifact
    cell = {name: inputs[name] for name in ("garment_mesh", "scene")}
    begin = shortened(read_episode(out / "episodes" / "0000"), 0.3)
    write_episode(tmp_path / "same", begin)
    assert replay_commands(cell, tmp_path / "same").same
    heavier = {**begin.about["physics"], "area_density_kg_m2": {"value": 0.6, "ci95": None}}
    write_episode(tmp_path / "other", replace(begin, about={**begin.about, "physics": heavier}))
    assert not replay_commands(cell, tmp_path / "other").same
    silent = {key: value for key, value in begin.about.items() if key != "physics"}
    write_episode(tmp_path / "old", replace(begin, about=silent))
    with pytest.raises(BadInput, match=r"old/episode\.json: key physics is missing.*made again"):
        replay_commands(cell, tmp_path / "old")


def test_the_session_opens_as_usd_with_moving_garment_and_links(artifact):
    from pxr import Usd, UsdGeom

    out, facts = artifact
    folder = out / "episodes" / f"{facts['attempt_count'] - 1:04d}"
    stage = Usd.Stage.Open(str(folder / "session.usdc"))
    episode = read_episode(folder)
    points = UsdGeom.Mesh.Get(stage, "/session/garment").GetPointsAttr()
    assert np.array(points.Get(100)) == pytest.approx(episode.garment_m[100])
    finger = UsdGeom.Xformable.Get(stage, "/session/left/finger_1")
    assert finger.GetLocalTransformation(0) != finger.GetLocalTransformation(100)


def test_damaged_demonstrations_do_not_pass_the_check(artifact, tmp_path):
    from sim1.episode import episode_folders, write_episode

    bad = tmp_path / "artifact"
    shutil.copytree(artifact[0], bad)
    for folder in episode_folders(bad):
        episode = read_episode(folder)
        joints = episode.joints_rad.copy()
        joints[50, 0, 1] = -0.5  # below the limit, and a jump
        write_episode(folder, replace(episode, joints_rad=joints, about={**episode.about, "success": False}))
    failed = {finding.name for finding in check_seed_demos(bad) if not finding.passed}
    assert {"a_demonstration_succeeds", "joints_within_limits", "joint_speeds_within_limits"} <= failed


def test_a_task_out_of_reach_is_recorded_as_unreachable(inputs):
    from sim1.cloth.cell import CellConfig
    from sim1.cloth.garment import read_garment_mesh
    from sim1.cloth.physics import read_physics
    from sim1.robot.expert_task import read_task
    from sim1.robot.expert_variation import PLAIN
    from sim1.robot.session import demonstrate

    scene = read_scene(inputs["scene"]["towel"])
    physics = read_physics(inputs["calibrated_physics"]["towel"] / "cell.yaml")
    mesh = read_garment_mesh(inputs["garment_mesh"]["towel"])
    cell = Cell(mesh, scene, physics, CellConfig(substeps=2, iterations=1, self_contact=False))
    far = (TOWEL.rest_m + np.array([0.0, 0.42, 0.002])).astype(np.float32)
    episode = demonstrate(cell, read_task(inputs["task"]["towel"]), far, PLAIN, {})
    assert episode.about["failure"] == "unreachable"
    assert "out of reach" in episode.about["note"]


def test_a_second_step_grasps_where_the_first_left_the_garment_and_folds_on_its_own_line(inputs, tmp_path):
    """The near corners lie 10 mm further in y than ideal folds put them; the line is that of the ideal fold before it."""
    from sim1.motion.commands import Arms
    from sim1.robot.expert import Workspace, plan_step
    from sim1.robot.expert_task import find_keypoints, ideal_fold, read_task
    from sim1.robot.expert_variation import PLAIN

    document = yaml.safe_load(inputs["task"]["towel"].read_text())
    document["keypoints"] |= {"left": [0.0, 1.0], "right": [0.0, -1.0]}
    sides = {
        "name": "sides in",
        "left": {"grasp": "left", "fold": {"axis": "y", "at": 0.9}},
        "right": {"grasp": "right", "fold": {"axis": "y", "at": 0.1}},
    }
    document["steps"].insert(0, sides)
    (tmp_path / "two.yaml").write_text(yaml.safe_dump(document))
    task = read_task(tmp_path / "two.yaml")
    arms = Arms.of_scene(read_scene(inputs["scene"]["towel"]))
    workspace = Workspace.of((arms.arm, arms.arm), read_scene(inputs["scene"]["towel"]))
    start = TOWEL.rest_m + np.array([0.0, 0.0, 0.002])
    now = np.column_stack([ideal_fold(start, task, 1), start[:, 2]]) + np.array([0.0, 0.01, 0.0])

    plan = plan_step(workspace, task, 1, start, now, workspace.home_rad, PLAIN)
    tools = arms.tool_path(plan.joints_rad, plan.openness)
    closed = np.flatnonzero(plan.openness[:, 0] < 0.01)
    step, marks = task.steps[1], find_keypoints(start, task)
    for side, move in enumerate((step.left, step.right)):
        inwards = np.array(move.inset_m) * [1.0, (-1.0, 1.0)[side]]
        grasp, laid = (tools.position_m[closed[i], side, :2] for i in (0, -1))
        assert grasp == pytest.approx(now[marks[move.grasp], :2] + inwards, abs=0.002)
        nearer_m = (-0.005, 0.005)[side]  # hands come together, for closing fingers draw the cloth taut
        assert laid == pytest.approx([-grasp[0] - step.short_m, grasp[1] + nearer_m], abs=0.003)


def test_a_full_disk_surfaces_from_the_writer_thread(artifact, inputs, tmp_path):
    from sim1.robot.session_writer import SessionWriter

    episode = read_episode(artifact[0] / "episodes" / "0000")
    (tmp_path / "episodes").write_text("a file where the folder should be")
    with (
        pytest.raises(OSError, match="episodes"),
        SessionWriter(tmp_path / "episodes", TOWEL.faces, read_scene(inputs["scene"]["towel"]), limit=1) as writer,
    ):
        writer.put("0000", episode)
