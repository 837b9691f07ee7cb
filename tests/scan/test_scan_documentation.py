"""What docs/scan-format.md shows is what the readers take."""

import re
from pathlib import Path

from sim1.robot.expert_task import read_task
from sim1.scan.garment_file import read_garment_file

PAGE = Path(__file__).parents[2] / "docs" / "scan-format.md"


def test_the_garment_file_and_the_task_file_of_the_page_are_accepted(tmp_path):
    garment, task = re.findall(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "garment.yaml").write_text(garment)
    (tmp_path / "task.yaml").write_text(task)
    assert read_garment_file(tmp_path / "garment.yaml").units == "mm"
    assert read_task(tmp_path / "task.yaml").steps[0].left.grasp == "near_left"
