"""Sources that lie elsewhere, as on the drive of a lab, and are linked to: what a link leads to counts."""

from types import SimpleNamespace

import pytest

from assets_defs._digest import content_files, digest_path
from assets_defs._sources import source
from sim1.stage import BadInput


@pytest.fixture
def drive(tmp_path):
    """A folder outside of every home, with a scan in a folder of its own."""
    (tmp_path / "drive" / "monday").mkdir(parents=True)
    (tmp_path / "drive" / "monday" / "scan.txt").write_text("point 1 1 1")
    return tmp_path / "drive"


def test_a_change_behind_a_linked_folder_makes_stale_what_was_made_of_it(made, drive):
    made.stages(scan={"run": "toy_stages:work"})
    (made.root / "data" / "scans" / "towel" / "more").symlink_to(drive / "monday")
    assert "scan/towel" in made.run().made
    (drive / "monday" / "scan.txt").write_text("point 2 2 2 2")
    assert list(made.run(nodes={"scan"}).made) == ["scan/towel"]


def test_a_folder_counts_the_same_whether_it_is_there_or_linked_to(tmp_path, drive):
    (tmp_path / "there" / "monday").mkdir(parents=True)
    (tmp_path / "there" / "monday" / "scan.txt").write_text("point 1 1 1")
    (tmp_path / "linked").mkdir()
    (tmp_path / "linked" / "monday").symlink_to(drive / "monday")
    (tmp_path / "whole").symlink_to(drive)
    digests = {digest_path(tmp_path / name) for name in ("there", "linked", "whole")}
    assert len(digests) == 1


def test_links_that_lead_back_lead_nowhere_or_come_twice_are_no_trouble(tmp_path, drive):
    (drive / "monday" / "back").symlink_to(drive)
    (drive / "itself").symlink_to(drive / "itself")
    (drive / "lost").symlink_to(tmp_path / "no such drive")
    (drive / "again").symlink_to(drive / "monday")
    assert [name for name, _ in content_files(drive)] == ["again/scan.txt", "monday/scan.txt"]
    assert list(content_files(tmp_path / "gone meanwhile")) == []


def test_a_link_to_a_drive_that_is_not_mounted_is_told_and_nothing_stands_in_for_it(tmp_path):
    stage = SimpleNamespace(name="recordings", sources={}, optional_sources={"own": "data/recordings/{garment}"})
    home, node = SimpleNamespace(root=tmp_path), SimpleNamespace(stage=stage)
    assert source(home, node, "towel", "own") is None
    (tmp_path / "data" / "recordings").mkdir(parents=True)
    (tmp_path / "data" / "recordings" / "towel").symlink_to(tmp_path / "lab")
    with pytest.raises(BadInput, match=r"recordings/towel: a link to .*lab, which is not there; mount its drive"):
        source(home, node, "towel", "own")
