import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml

from sim1.scene.environment import look_at, read_cameras, read_table
from sim1.stage import BadInput

ENVIRONMENT = Path(__file__).parents[2] / "data" / "environment"


@pytest.fixture
def environment(tmp_path):
    return Path(shutil.copytree(ENVIRONMENT, tmp_path / "environment"))


def edit(path: Path, change) -> None:
    document = yaml.safe_load(path.read_text())
    change(document)
    path.write_text(yaml.safe_dump(document))


@pytest.mark.parametrize("name", ["workbench", "dining_table"])
def test_every_table_has_its_measured_size_in_metres_and_its_top_at_the_origin(name):
    mesh, size_m, tolerance_m = read_table(ENVIRONMENT, name)
    np.testing.assert_allclose(mesh.extents, size_m, atol=tolerance_m)
    np.testing.assert_allclose(mesh.bounds[0, :2], -mesh.bounds[1, :2], atol=1e-9)
    assert mesh.bounds[1, 2] == pytest.approx(0.0, abs=1e-12)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(np.prod(size_m), rel=0.02)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.update(units="mm"), "the mesh would fit in units: m"),
        (lambda t: t.update(units="feet"), "expected one of"),
        (lambda t: t.update(size_m=[0.8, 1.25, 0.03]), "measure the table again"),
        (lambda t: t.update(mesh="tables/absent.obj"), "no such file"),
        (lambda t: t.update(size_m=[0.8, 1.2]), r"tables\.workbench\.size_m"),
        (lambda t: t.update(colour="red"), "colour"),
        (lambda t: t.pop("tolerance_m"), "tolerance_m"),
    ],
)
def test_a_table_that_does_not_agree_with_its_measurement_is_refused(environment, change, message):
    edit(environment / "tables.yaml", lambda document: change(document["tables"]["workbench"]))
    with pytest.raises(BadInput, match=message) as caught:
        read_table(environment, "workbench")
    assert "workbench" in str(caught.value) or "absent.obj" in str(caught.value)


def test_a_mesh_scaled_to_millimetres_is_found_out(environment):
    path = environment / "tables" / "workbench.obj"
    lines = [line.split() for line in path.read_text().splitlines()]
    scaled = [["v", *(str(1000 * float(x)) for x in line[1:])] if line[:1] == ["v"] else line for line in lines]
    path.write_text("\n".join(" ".join(line) for line in scaled))
    with pytest.raises(BadInput, match="the mesh would fit in units: mm"):
        read_table(environment, "workbench")


@pytest.mark.parametrize("content", ["", "v 0 0 0\n", "no mesh at all", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"])
def test_a_damaged_mesh_is_refused(environment, content):
    (environment / "tables" / "workbench.obj").write_text(content)
    with pytest.raises(BadInput, match=r"workbench\.obj"):
        read_table(environment, "workbench")


def test_an_unknown_table_is_refused_with_those_that_exist():
    with pytest.raises(BadInput, match=r"no table 'desk'.*workbench"):
        read_table(ENVIRONMENT, "desk")


def test_the_head_camera_sees_the_whole_work_area():
    head, wrist = read_cameras(ENVIRONMENT)
    assert wrist.link == "link6"
    for x in (-0.3, 0.3):
        for y in (-0.375, 0.375):
            seen = np.linalg.inv(head.pose) @ [x, y, 0, 1]
            assert seen[2] < 0  # in front
            pixel = head.fy_px * np.array([seen[0], -seen[1]]) / -seen[2] + [head.width / 2, head.height / 2]
            assert (pixel > 0).all()
            assert (pixel < [head.width, head.height]).all()
            assert (pixel[0] < head.width / 2) == (y > 0)  # left is left
    ahead = head.pose[:3, :3] @ [0, 0, -1]
    np.testing.assert_allclose(np.cross(ahead, -head.pose[:3, 3]), 0, atol=1e-9)  # at the middle of the table


def test_look_at_is_a_right_handed_rotation_with_up_in_the_picture():
    pose = look_at(np.array([1.0, 2, 3]), np.array([0.0, 0.5, 0]), np.array([0.0, 0, 1]))
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1)
    assert pose[2, 1] > 0


def test_a_camera_that_looks_along_its_up_direction_is_refused(environment):
    edit(environment / "cameras.yaml", lambda d: d["head"].update(eye_m=[0, 0, 1.0]))
    with pytest.raises(BadInput, match="looks along its up direction"):
        read_cameras(environment)
