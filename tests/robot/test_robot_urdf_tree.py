"""Links that hang on each other in a ring."""

from pathlib import Path

import pytest

from sim1.robot.urdf import read_urdf
from sim1.stage import BadInput

URDF = Path(__file__).parents[2] / "data" / "robot" / "robot.urdf"


def test_links_that_hang_on_each_other_in_a_ring_are_refused(tmp_path):
    """As many joints as a tree has, and no link with two parents: counting does not tell."""
    text = URDF.read_text()
    name = 'name="joint2"'
    before, after = text.split(name)
    assert '<parent link="link1"/>' in after
    path = tmp_path / "robot.urdf"
    path.write_text(before + name + after.replace('<parent link="link1"/>', '<parent link="link4"/>', 1))
    with pytest.raises(
        BadInput, match=r"robot\.urdf: link '\w+' hangs on itself by way of .*'link4'.*correct the parent"
    ):
        read_urdf(path)
