"""Commands that no joint can carry out: one demonstration of a person fails by them, not all that were given."""

import json
from dataclasses import replace

import numpy as np
import pytest
from small_towel import TOWEL

import sim1.robot.session
from sim1.cloth.cell import Cell, CellConfig, SimulationBroke
from sim1.cloth.garment import read_garment_mesh
from sim1.cloth.physics import read_physics
from sim1.episode import write_episode
from sim1.robot.expert import TooFast
from sim1.robot.expert_task import read_task
from sim1.robot.expert_variation import PLAIN
from sim1.robot.session import demonstrate, follow
from sim1.robot.stage import check_seed_demos
from sim1.robot.teleoperation import Commands
from sim1.scene.description import read_scene

ROLL = 5  # the last joint, from -1.57 to 1.57 rad
FRAMES = 8
LYING = (TOWEL.rest_m + np.array([0.0, 0.0, 0.002])).astype(np.float32)


@pytest.fixture(scope="module")
def cell(inputs):
    mesh, scene = read_garment_mesh(inputs["garment_mesh"]["towel"]), read_scene(inputs["scene"]["towel"])
    physics = read_physics(inputs["calibrated_physics"]["towel"] / "cell.yaml")
    return Cell(mesh, scene, physics, CellConfig(substeps=2, iterations=1, self_contact=False))


@pytest.fixture(scope="module")
def task(inputs):
    return read_task(inputs["task"]["towel"])


def rolling(cell, way_rad) -> Commands:
    """Arms at home whose left tool turns along `way_rad` (T,), float32 as in a dataset."""
    home = np.stack([cell.scene.home_rad[name] for name in ("left", "right")])
    joints = np.repeat(home[None], len(way_rad), axis=0).astype(np.float32)
    joints[:, 0, ROLL] = way_rad
    return Commands(
        origin="towel, episode 3",
        start_joints_rad=joints[0].astype(float),
        start_openness=np.ones(2),
        joints_rad=joints.astype(float),
        openness=np.ones((len(way_rad), 2)),
    )


def test_a_command_that_rounding_puts_beyond_a_limit_is_recorded_at_the_limit(cell, task):
    commands = rolling(cell, np.linspace(1.5, 1.57, FRAMES))
    assert commands.joints_rad.max() > 1.57  # as float32 has it
    episode = follow(cell, task, LYING, commands, {})
    assert episode.command_joints_rad[..., ROLL].max() == 1.57
    assert episode.about["failure"] == "missed grasp"  # what became of the towel


def test_a_command_beyond_a_limit_fails_its_demonstration_with_place_value_and_remedy(cell, task):
    way = np.full(FRAMES, 1.5)
    way[4] = 1.6
    episode = follow(cell, task, LYING, rolling(cell, way), {})
    assert episode.about["failure"] == "beyond joint limits"
    place = "demonstrations/towel, episode 3: left_joint_6_rad at frame 4 (0.13 s, 30 frames a second)"
    assert episode.about["note"].startswith(f"{place} is asked to be at 1.6 rad, ")
    assert (
        "its limits are -1.57 and 1.57; demonstrate it within them, or leave this episode out" in episode.about["note"]
    )


def test_a_command_that_a_joint_does_not_keep_up_with_fails_its_demonstration(cell, task):
    way = np.where(np.arange(FRAMES) < 3, 0.0, 1.0)
    episode = follow(cell, task, LYING, rolling(cell, way), {})
    assert episode.about["failure"] == "too fast"
    note = episode.about["note"]
    assert "episode 3: left_joint_6_rad at frame 3 (0.10 s, 30 frames a second) is 0.833 rad behind its command" in note
    assert "its limit, 5 rad/s; demonstrate it slower, or leave this episode out" in note


@pytest.mark.parametrize(("roll_rad", "failure"), [(1.5, "simulation broke"), (1.6, "beyond joint limits")])
def test_a_simulation_that_breaks_while_the_garment_comes_to_rest_fails_that_demonstration_alone(
    cell, task, monkeypatch, roll_rad, failure
):
    def step(cell, joints_rad, openness):
        steps(cell, joints_rad, openness)
        if cell.frame == FRAMES + 2:
            raise SimulationBroke(cell.frame, 3, "vertex 3 flew away")

    steps = Cell.step
    monkeypatch.setattr(Cell, "step", step)
    episode = follow(cell, task, LYING, rolling(cell, np.full(FRAMES, roll_rad)), {})
    assert episode.frame_count == FRAMES + 2
    assert (episode.about["success"], episode.about["failure"]) == (False, failure)
    assert ("vertex 3 flew away" in episode.about["note"]) == (failure == "simulation broke")


@pytest.fixture(scope="module")
def artifact(cell, task, tmp_path_factory):
    """One attempt of each kind; the first is taken to have folded the towel."""
    out = tmp_path_factory.mktemp("demonstrations")
    ways = [np.linspace(1.5, 1.57, FRAMES), np.full(FRAMES, 1.7), np.where(np.arange(FRAMES) < 3, 0.0, 1.0)]
    for number, way in enumerate(ways):
        episode = follow(cell, task, LYING, rolling(cell, way), {})
        if number == 0:
            episode = replace(episode, about={**episode.about, "success": True, "failure": None})
        write_episode(out / "episodes" / f"{number:04d}", episode)
    arm = cell.arms[0]
    limits = {"joint_lower_rad": arm.lower_rad, "joint_upper_rad": arm.upper_rad}
    limits |= {"joint_speed_rad_s": arm.velocity_limit_rad_s}
    again = {"attempt": 0, "recorded_count": FRAMES, "frame_count": FRAMES, "largest_difference_m": 0.0}
    facts = {name: values.tolist() for name, values in limits.items()} | {"replay": again}
    (out / "cell.json").write_text(json.dumps(facts))
    return out


def test_demonstrations_that_cannot_be_followed_do_not_keep_the_others_out_of_the_store(artifact):
    assert not [finding for finding in check_seed_demos(artifact) if finding.blocking and not finding.passed]


def test_where_none_succeeds_the_check_says_which_command_of_which_demonstration_is_at_fault(artifact, tmp_path):
    for source in sorted(artifact.rglob("episode.*")):
        folder = tmp_path / source.parent.relative_to(artifact)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / source.name).write_bytes(source.read_bytes().replace(b'"success": true', b'"success": false'))
    (tmp_path / "cell.json").write_bytes((artifact / "cell.json").read_bytes())
    [failed] = [finding for finding in check_seed_demos(tmp_path) if finding.blocking and not finding.passed]
    assert failed.name == "a_demonstration_succeeds"
    assert "; attempt 0001: demonstrations/towel, episode 3: left_joint_6_rad at frame 0 (0.00 s" in failed.detail
    assert "; attempt 0002: " in failed.detail


def test_an_expert_whose_plan_is_too_fast_fails_and_does_not_crash(cell, task, monkeypatch):
    def plan_step(*_):
        raise TooFast(1.2)

    monkeypatch.setattr(sim1.robot.session, "plan_step", plan_step)
    about = demonstrate(cell, task, LYING, PLAIN, {}).about
    assert (about["success"], about["failure"]) == (False, "too fast")
    assert "120 % of its speed limit" in about["note"]
