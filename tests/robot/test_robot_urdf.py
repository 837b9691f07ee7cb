from pathlib import Path

import pytest

from sim1.robot.kinematics import Arm
from sim1.robot.urdf import read_urdf
from sim1.stage import BadInput

URDF = Path(__file__).parents[2] / "data" / "robot" / "robot.urdf"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('upper="3.14" velocity="3"', 'upper="-1" velocity="3"', "do not make sense"),
        ('<child link="link3"/>', '<child link="link9"/>', "links that do not exist"),
        ('<child link="link3"/>', '<child link="link2"/>', "do not form one tree"),
        ('type="prismatic"', 'type="screw"', "expected a parent, a child and one of"),
        ('<origin xyz="0.145 0 0"/>', '<origin xyz="0.145 nan 0"/>', "not 3 finite numbers"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 2 0"/>', "do not make sense"),
        ('radius="0.045"', 'radius="-0.045"', "greater than 0"),
        ("</robot>", "", "not a readable URDF"),
    ],
)
def test_a_damaged_urdf_is_refused(tmp_path, old, new, message):
    text = URDF.read_text()
    assert old in text
    damaged = tmp_path / "robot.urdf"
    damaged.write_text(text.replace(old, new))
    with pytest.raises(BadInput, match=message) as caught:
        read_urdf(damaged)
    assert "robot.urdf" in str(caught.value)


def test_an_arm_with_another_number_of_joints_is_refused(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(URDF.read_text().replace('name="joint5" type="revolute"', 'name="joint5" type="fixed"'))
    with pytest.raises(BadInput, match="5 moving joints"):
        Arm.from_urdf(path)


def test_masses_and_inertias_are_those_of_real_bodies():
    import xml.etree.ElementTree as ElementTree

    for link in ElementTree.parse(URDF).getroot().findall("link"):
        if link.find("inertial") is None:
            assert link.get("name") == "tool"  # a frame, not a body
            continue
        inertia = [float(link.find("inertial/inertia").get(key)) for key in ("ixx", "iyy", "izz")]
        assert min(inertia) > 0
        assert 2 * max(inertia) <= sum(inertia) * 1.0001  # triangle inequality
    total = sum(link.mass_kg for link in read_urdf(URDF).links.values())
    assert 3 < total < 8  # kg
