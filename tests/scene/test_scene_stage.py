import hashlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scene_garments import towel_points

from sim1.scene.description import read_scene, write_scene
from sim1.scene.stage import SceneConfig, check_scene, scene
from sim1.stage import BadInput


@pytest.fixture(scope="module")
def original(inputs_in, tmp_path_factory):
    out = tmp_path_factory.mktemp("original") / "scene"
    out.mkdir()
    facts = scene(inputs_in(out.parent, towel_points()), out, SceneConfig())
    return out, facts


@pytest.fixture
def made(original, tmp_path):
    """A towel's scene, to be damaged at will."""
    shutil.copytree(original[0], tmp_path / "made")
    return tmp_path / "made", original[1]


def digest(folder: Path) -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.iterdir())}


def failed(artifact: Path) -> set[str]:
    return {finding.name for finding in check_scene(artifact) if not finding.passed}


def test_a_towel_scene_passes_its_checks_and_says_what_it_holds(made):
    out, facts = made
    assert failed(out) == set()
    assert len(check_scene(out)) == 9
    assert facts["garment_size_lying_m"] == [0.4, 0.6, 0.0]
    assert facts["garment_reached_share"] == 1.0
    assert facts["work_region_leaning_45_deg_share"] == 1.0
    assert 0.5 < facts["work_region_straight_down_share"] < 1.0
    assert facts["calibration"].startswith("virtual")
    for name in ("scene.png", "reach.png"):
        with Image.open(out / name) as picture:
            assert picture.width > 800
        assert (out / name).stat().st_size < 200_000


def test_the_same_inputs_give_the_same_bytes(made, scene_inputs, towel, tmp_path):
    again = tmp_path / "again"
    again.mkdir()
    scene(scene_inputs(towel), again, SceneConfig())
    assert digest(again) == digest(made[0])
    for path in again.glob("*.[ujo]*"):
        assert str(tmp_path) not in path.read_text()


def test_a_shirt_lies_within_reach(scene_inputs, shirt, tmp_path):
    out = tmp_path / "scene"
    out.mkdir()
    facts = scene(scene_inputs(shirt, "tshirt"), out, SceneConfig())
    assert failed(out) == set()
    assert facts["garment_reached_share"] > 0.95


def test_the_usd_reopens_with_units_bounds_and_cameras(made):
    from pxr import Usd, UsdGeom

    from sim1.scene.usd import garment_points

    out, _ = made
    stage = Usd.Stage.Open(str(out / "scene.usda"))
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert str(stage.GetDefaultPrim().GetPath()) == "/scene"
    boxes = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_])
    table = boxes.ComputeWorldBound(stage.GetPrimAtPath("/scene/table")).ComputeAlignedRange()
    np.testing.assert_allclose([*table.GetMin(), *table.GetMax()], [-0.4, -0.6, -0.03, 0.4, 0.6, 0.0], atol=1e-6)
    description = read_scene(out)
    placed = description.place_garment(towel_points().reshape(-1, 3))
    np.testing.assert_allclose(garment_points(out / "scene.usda"), placed, atol=1e-6)
    poses = UsdGeom.XformCache()
    camera = UsdGeom.Camera.Get(stage, "/scene/cameras/head")
    np.testing.assert_allclose(
        np.array(poses.GetLocalToWorldTransform(camera.GetPrim())).T, description.cameras["head"].pose
    )
    head = description.cameras["head"]
    assert camera.GetFocalLengthAttr().Get() / camera.GetVerticalApertureAttr().Get() == pytest.approx(
        head.fy_px / head.height
    )
    assert UsdGeom.Camera.Get(stage, "/scene/arms/left/link6/camera")
    assert "@" not in (out / "scene.usda").read_text()  # no reference to another file


def test_the_robot_in_the_usd_stands_where_its_kinematics_say(made):
    from pxr import Usd, UsdGeom

    from sim1.robot.kinematics import Arm

    out, _ = made
    description, stage, poses = read_scene(out), Usd.Stage.Open(str(out / "scene.usda")), UsdGeom.XformCache()
    arm = Arm.from_urdf(description.urdf)
    for name, base in description.base_to_world.items():
        tool = np.array(poses.GetLocalToWorldTransform(stage.GetPrimAtPath(f"/scene/arms/{name}/tool"))).T
        np.testing.assert_allclose(tool, base @ arm.forward(description.home_rad[name]), atol=1e-9)
        assert 0.05 < tool[2, 3] < 0.5  # above the table


def test_garment_colours_come_from_the_texture(made):
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(made[0] / "scene.usda"))
    mesh = UsdGeom.Mesh.Get(stage, "/scene/garment/mesh0")
    colors = np.array(mesh.GetDisplayColorPrimvar().Get())
    points, faces = np.array(mesh.GetPointsAttr().Get()), np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    upper = points[faces].mean(axis=1)[:, 1] > 0.3  # v runs along y of the towel
    np.testing.assert_allclose(colors[upper], np.tile([1, 0, 0], (upper.sum(), 1)))
    np.testing.assert_allclose(colors[~upper], np.tile([0, 0, 1], ((~upper).sum(), 1)))


def test_scene_json_survives_reading_and_writing(made, tmp_path):
    out, _ = made
    copy = tmp_path / "elsewhere"
    shutil.copytree(out, copy)
    write_scene(copy, read_scene(copy))
    assert (copy / "scene.json").read_bytes() == (out / "scene.json").read_bytes()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(schema="sim1.scene/2"), "schema"),
        (lambda d: d.pop("garment"), "top level"),
        (lambda d: d["table"].update(colour="red"), "table has"),
        (lambda d: d["table"].update(size_m=[0.8, -1.2, 0.03]), "greater than 0"),
        (lambda d: d["table"].update(mesh="/table.obj"), "inside the artifact"),
        (lambda d: d.update(urdf="absent.urdf"), "inside the artifact"),
        (lambda d: d["arms"]["left"].update(base_to_world=[[1, 2], [3, 4]]), r"arms\.left\.base_to_world"),
        (lambda d: d["arms"]["right"]["base_to_world"][0].__setitem__(0, 2.0), "not a rigid motion"),
        (lambda d: d["cameras"]["head"].update(fy_px="wide"), r"cameras\.head\.fy_px"),
        (lambda d: d["cameras"]["head"].update(width=640.5), "whole pixels"),
    ],
)
def test_a_damaged_scene_is_refused_and_fails_its_check(made, change, message):
    path = made[0] / "scene.json"
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))
    with pytest.raises(BadInput, match=message) as caught:
        read_scene(made[0])
    assert "scene.json" in str(caught.value)
    assert failed(made[0]) == {"scene_readable"}


def test_checks_notice_what_is_physically_wrong(made):
    out, _ = made
    path = out / "scene.json"
    original = json.loads(path.read_text())

    def with_change(change) -> set[str]:
        document = json.loads(json.dumps(original))
        change(document)
        path.write_text(json.dumps(document))
        found = failed(out)
        path.write_text(json.dumps(original))
        return found

    assert with_change(lambda d: d["table"].update(size_m=[0.9, 1.2, 0.03])) == {"table_has_measured_size"}
    assert with_change(lambda d: d["arms"]["left"]["base_to_world"][2].__setitem__(3, 0.3)) == {"arms_stand_on_table"}
    assert with_change(lambda d: d["arms"]["left"]["base_to_world"][1].__setitem__(3, -0.2)) == {"arms_apart_at_home"}
    assert with_change(lambda d: d["arms"]["left"].update(home_rad=[0, -0.5, 0, 0, 0, 0])) == {
        "joint_limits_make_sense"
    }

    def step_back(document):
        for arm in document["arms"].values():
            arm["base_to_world"][0][3] -= 0.4

    assert with_change(step_back) == {"garment_within_reach"}
    usd = out / "scene.usda"
    usd.write_text(usd.read_text().replace("metersPerUnit = 1", "metersPerUnit = 0.01"))
    assert failed(out) == {"usd_is_metric_and_complete"}


def test_a_garment_larger_than_the_table_fails_its_check(scene_inputs, blanket, tmp_path):
    out = tmp_path / "scene"
    out.mkdir()
    scene(scene_inputs(blanket, "blanket"), out, SceneConfig())
    assert failed(out) == {"garment_lies_on_table", "garment_clear_of_arms", "garment_within_reach"}


@pytest.mark.parametrize("damage", ["mesh.npz", "texture.png"])
def test_a_damaged_garment_mesh_is_refused(scene_inputs, towel, tmp_path, damage):
    inputs = scene_inputs(towel)
    (inputs["garment_mesh"]["towel"] / damage).write_bytes(b"PK broken")
    out = tmp_path / "scene"
    out.mkdir()
    with pytest.raises(BadInput, match="make garment_mesh again"):
        scene(inputs, out, SceneConfig())


def test_another_table_is_one_word(scene_inputs, towel, tmp_path):
    out = tmp_path / "scene"
    out.mkdir()
    facts = scene(scene_inputs(towel), out, SceneConfig(table="dining_table"))
    assert facts["table_size_m"] == [0.9, 1.6, 0.04]
    assert failed(out) == set()
