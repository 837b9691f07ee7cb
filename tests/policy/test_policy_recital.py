"""A demonstration that folds, said again command by command through the trials: what drives well is seen to succeed."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image

from sim1.cloth.cell import Cell, CellConfig
from sim1.cloth.garment import grid_towel, read_garment_mesh
from sim1.cloth.physics import nominal_from_priors, read_physics, write_physics
from sim1.episode import RATE_HZ, Episode, write_episode
from sim1.motion.commands import FREE, Arms
from sim1.motion.placement import fitted_placement
from sim1.policy.lessons import REAL, ModelKey
from sim1.policy.rollout import Driving
from sim1.policy.stage import PolicyConfig
from sim1.policy.time_limit import TimeLimit
from sim1.policy.trials import Trial, TrialSettings, drive, open_bench
from sim1.policy.worlds import SIMULATOR
from sim1.robot.expert_task import read_task
from sim1.robot.expert_variation import PLAIN
from sim1.robot.session import demonstrate, settle
from sim1.scene.description import read_scene
from sim1.scene.stage import SceneConfig, scene

DATA = Path(__file__).parents[2] / "data"
TOWEL = grid_towel(0.22, 0.30, 0.026)  # small enough to be folded in seconds
DRIVING = Driving(rate_hz=10, replan_frames=5, decay=0.1)
CHUNK_FRAMES = 10


@pytest.fixture(scope="module")
def demonstrated(tmp_path_factory):
    """Inputs of `open_bench` with one demonstration of the scripted expert, that demonstration, and the arms."""
    folder = tmp_path_factory.mktemp("recital")
    names = ("garment_mesh", "scene", "calibrated_physics", "seed_demos", "reality", "real_demos")
    place = {name: folder / name for name in names}
    for path in place.values():
        path.mkdir()
    uv = (TOWEL.vertices_m[:, :2] / np.ptp(TOWEL.vertices_m[:, :2], axis=0) + 0.5)[TOWEL.faces]
    np.savez(place["garment_mesh"] / "mesh.npz", **vars(TOWEL), uv=uv)
    Image.fromarray(np.full((8, 8, 3), 180, np.uint8)).save(place["garment_mesh"] / "texture.png")
    parts = {"garment_mesh": place["garment_mesh"], "robot": DATA / "robot", "environment": DATA / "environment"}
    scene({name: {"towel": path} for name, path in parts.items()}, place["scene"], SceneConfig())
    fabric = yaml.safe_load((DATA / "garments" / "towel.yaml").read_text())["fabric"]
    write_physics(place["calibrated_physics"] / "cell.yaml", nominal_from_priors(fabric))
    task = yaml.safe_load((DATA / "tasks" / "towel.yaml").read_text())
    task["steps"][0] |= {"carry_s": 1.6, "short_m": 0.0}
    (place["seed_demos"] / "task.json").write_text(json.dumps(task))

    mesh, cell_scene = read_garment_mesh(place["garment_mesh"]), read_scene(place["scene"])
    physics = read_physics(place["calibrated_physics"] / "cell.yaml")
    cell = Cell(mesh, cell_scene, physics, CellConfig(substeps=6, iterations=4))
    lying = settle(cell, longest_s=4.0, rest_speed_m_s=0.03)
    np.savez(place["seed_demos"] / "start.npz", garment_m=lying)
    demo = demonstrate(cell, read_task(place["seed_demos"] / "task.json"), lying, PLAIN, {"garment": "towel"})
    write_episode(place["seed_demos"] / "episodes" / "0000", demo)
    return {name: {"towel": path} for name, path in place.items()}, demo, Arms.of_scene(cell_scene)


class Reciter:
    """Looks once where the garment lies, and says the demonstration's commands as they are there."""

    def __init__(self, demo: Episode, arms: Arms) -> None:
        self._demo, self._arms, self._frame = demo, arms, -1

    def see(self, cell) -> None:
        self._frame += 1
        if self._frame == 0:
            demo, even = self._demo, np.ones(len(cell.garment_m))
            self.placement = fitted_placement(demo.garment_m[0].astype(float), np.asarray(cell.garment_m, float), even)
            way = self._arms.tool_path(demo.command_joints_rad, demo.command_openness).moved(self.placement)
            joints = self._arms.joints_for(way, demo.joints_rad[0], FREE)
            said = np.concatenate([joints, demo.command_openness[..., None]], axis=-1).reshape(len(joints), 14)
            self._rows = said[DRIVING.stride - 1 :: DRIVING.stride]  # to be reached by the next policy frame

    def plan(self) -> np.ndarray:
        ahead = np.arange(self._frame, self._frame + CHUNK_FRAMES)
        return self._rows[np.minimum(ahead, len(self._rows) - 1)]


@pytest.mark.slow
@pytest.mark.parametrize("shift", ["in-domain", "spatial"])
def test_a_pilot_that_recites_a_demonstration_that_folds_succeeds_wherever_the_garment_lies(demonstrated, shift):
    inputs, demo, arms = demonstrated
    assert demo.about["success"]
    bench, pilot = open_bench(inputs, "towel", "simulator"), Reciter(demo, arms)
    limits = {"towel": TimeLimit(duration_s=demo.frame_count / RATE_HZ + 0.5, longest_of=REAL)}
    settings = TrialSettings(driving=DRIVING, limits=limits, config=PolicyConfig(shift_m=0.03))
    trial = Trial(model=ModelKey(REAL, 1, 0), garment="towel", shift=shift, number=1)  # turned by 13 degrees if at all
    row, history_m = drive(bench, trial, pilot, settings)
    assert (row["world"], row["success"], row["failure"]) == (SIMULATOR, True, None)
    figures = json.loads(row["figures"])
    assert figures["iou"] > 0.8
    assert figures["lifted_m"] > 0.05
    # The garment lay where the row says, and its fold is none along the axes of the world once it is turned.
    shift_m = (history_m[0] - demo.garment_m[0]).mean(axis=0)
    assert shift_m == pytest.approx([row["shift_x_m"], row["shift_y_m"], 0.0], abs=1e-6)
    assert row["turn_rad"] == pytest.approx(np.arctan2(pilot.placement[1, 0], pilot.placement[0, 0]), abs=1e-6)
    assert (abs(row["turn_rad"]) > 0.2) is (shift == "spatial")
    assert bench.judge(history_m)[0] is (shift == "in-domain")
