"""Cards of merged and split datasets: pictures and counts of their own, the licenses of all that went in."""

import re
import shutil

import pytest
from rendered_towel import written_dataset

from sim1.dataset.card import licenses_of
from sim1.dataset.reshape import merge, split
from sim1.stage import BadInput


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A dataset of four trajectories."""
    return written_dataset(tmp_path_factory.mktemp("cards"), (25, 28, 31, 22))


def test_a_card_with_pictures_and_every_license_goes_along(made, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(made, other)
    card = other / "README.md"
    card.write_text(re.sub("^license: .*$", "license: cc-by-4.0", card.read_text(), flags=re.MULTILINE))
    [own] = licenses_of(made)
    merge([made, other], tmp_path / "both")
    assert licenses_of(tmp_path / "both") == (own, "cc-by-4.0")
    assert "8 episodes" in (tmp_path / "both" / "README.md").read_text()
    split(tmp_path / "both", {"train": 0.75, "test": 0.25}, tmp_path / "parts", seed=0)
    for name, count in (("train", 6), ("test", 2)):
        part = tmp_path / "parts" / name
        assert licenses_of(part) == (own, "cc-by-4.0")
        assert f"\n{count} episodes" in (part / "README.md").read_text()
        assert {"frames.png", "motion.png"} <= {path.name for path in part.iterdir()}


def test_where_one_has_no_card_there_is_none_and_a_damaged_head_is_named(made, tmp_path):
    bare = tmp_path / "bare"
    shutil.copytree(made, bare)
    (bare / "README.md").unlink()
    merge([made, bare], tmp_path / "both")
    assert not (tmp_path / "both" / "README.md").exists()
    (bare / "README.md").write_text("---\nlicense\n---\n")
    with pytest.raises(BadInput, match=r"bare/README\.md: no license at its head"):
        merge([made, bare], tmp_path / "again")
    assert not list(tmp_path.glob("again*"))
