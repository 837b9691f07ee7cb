"""A file that is written is there whole, or as it was before."""

import pytest

from sim1.whole_file import whole_file


def test_it_is_in_its_place_once_it_is_whole(tmp_path):
    with whole_file(tmp_path / "a.txt") as part:
        part.write_text("half")
        assert not (tmp_path / "a.txt").exists()
        part.write_text("whole")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a.txt": "whole"}


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_what_was_there_stays_where_the_writing_is_cut_short(tmp_path, error):
    (tmp_path / "a.txt").write_text("before")

    def cut_short(part):
        part.write_text("half")
        raise error

    with pytest.raises(error), whole_file(tmp_path / "a.txt") as part:
        cut_short(part)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a.txt": "before"}


def test_what_a_killed_process_left_is_written_over(tmp_path):
    (tmp_path / "a.txt.part").write_text("half of an earlier one, and longer")
    with whole_file(tmp_path / "a.txt") as part:
        part.write_text("whole")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a.txt": "whole"}


def test_nothing_takes_its_place_where_nothing_was_written(tmp_path):
    (tmp_path / "a.txt").write_text("before")
    with pytest.raises(FileNotFoundError), whole_file(tmp_path / "a.txt"):
        pass
    assert (tmp_path / "a.txt").read_text() == "before"
