"""A small towel that the expert has folded."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from small_towel import FABRIC, TOWEL, place

from sim1.cloth.physics import nominal_from_priors, write_physics
from sim1.robot.stage import SeedDemosConfig, seed_demos
from sim1.scene.description import Scene, write_scene

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def inputs(tmp_path_factory) -> dict[str, dict[str, Path]]:
    folder = tmp_path_factory.mktemp("seed_inputs")
    for name in ("garment_mesh", "scene", "calibrated_physics"):
        (folder / name).mkdir()
    np.savez(folder / "garment_mesh" / "mesh.npz", vertices_m=TOWEL.vertices_m, faces=TOWEL.faces, rest_m=TOWEL.rest_m)
    for name in ("robot.urdf", "table.obj"):
        source = ROOT / "data" / "robot" / name
        (folder / "scene" / name).write_text(source.read_text() if source.is_file() else "# table\n")
    home = np.array([0.0, 0.6, 0.6, -0.9, 0.0, 0.0])
    scene = Scene(
        table_mesh=folder / "scene" / "table.obj",
        table_size_m=np.array([0.8, 1.2, 0.03]),
        table_top_m=0.0,
        urdf=folder / "scene" / "robot.urdf",
        base_to_world={"left": place((-0.36, 0.27, 0.15)), "right": place((-0.36, -0.27, 0.15))},
        home_rad={"left": home, "right": home},
        garment_place=place((0.0, 0.0, 0.004)),
        cameras={},
        wrist_cameras={},
    )
    write_scene(folder / "scene", scene)
    write_physics(folder / "calibrated_physics" / "cell.yaml", nominal_from_priors(FABRIC))
    task = yaml.safe_load((ROOT / "data" / "tasks" / "towel.yaml").read_text())
    task["steps"][0] |= {"lift_m": 0.08, "carry_s": 1.6}
    task["text"] = "fold the small towel"
    (folder / "towel.yaml").write_text(yaml.safe_dump(task))
    return {name: {"towel": folder / name} for name in ("garment_mesh", "scene", "calibrated_physics")} | {
        "task": {"towel": folder / "towel.yaml"}
    }


@pytest.fixture(scope="module")
def artifact(inputs, tmp_path_factory) -> tuple[Path, dict]:
    out = tmp_path_factory.mktemp("seed_demos")
    config = SeedDemosConfig(demo_count=1, attempts=2, substeps=6, iterations=4, replay_s=30.0)
    return out, seed_demos(inputs, out, config)
