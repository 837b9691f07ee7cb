"""The `lerobot/` of an artifact, given in its place, is cut up and put together with what lies beside it."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from rendered_towel import written_dataset
from typer.testing import CliRunner

from assets_defs.cli import app
from sim1.dataset.beside import FILES, artifact_of
from sim1.dataset.reshape import merge, split

HALVES = {"train": 0.5, "test": 0.5}


@pytest.fixture(scope="module")
def kin(tmp_path_factory):
    """An artifact of four trajectories of two demonstrations."""
    out = written_dataset(tmp_path_factory.mktemp("inner"), (10, 13, 10, 13))
    table = pd.read_parquet(out / "provenance.parquet")
    table.assign(sources=[["a"], ["b"], ["a"], ["b"]]).to_parquet(out / "provenance.parquet", index=False)
    return out


def used(folder):
    return set(np.concatenate(pd.read_parquet(folder / "provenance.parquet").sources.tolist()))


def test_kin_stay_together_also_where_the_lerobot_folder_of_the_artifact_is_given(kin, tmp_path):
    for seed in range(4):
        assert split(kin / "lerobot", HALVES, tmp_path / str(seed), seed) == {"train": 2, "test": 2}
        assert len(used(tmp_path / str(seed) / "train") | used(tmp_path / str(seed) / "test")) == 2
        assert used(tmp_path / str(seed) / "train").isdisjoint(used(tmp_path / str(seed) / "test"))


def test_what_lies_beside_is_kept_where_the_lerobot_folders_of_artifacts_are_merged(kin, tmp_path):
    assert merge([kin / "lerobot", kin], tmp_path / "twice") == 8
    assert [name for name in FILES if not (tmp_path / "twice" / name).is_file()] == []
    assert len(pd.read_parquet(tmp_path / "twice" / "provenance.parquet")) == 8


def test_the_artifact_is_found_from_within_and_through_links(kin, tmp_path, monkeypatch):
    (tmp_path / "link").symlink_to(kin / "lerobot")
    assert artifact_of(tmp_path / "link") == kin
    assert artifact_of(kin) == kin
    monkeypatch.chdir(kin / "lerobot")
    assert artifact_of(Path(".")) == kin
    shutil.copytree(kin / "lerobot", tmp_path / "lerobot")
    assert artifact_of(tmp_path / "lerobot") == tmp_path / "lerobot"  # nothing lies beside it


def test_where_nothing_is_known_of_the_episodes_the_command_says_so(kin, tmp_path):
    plain = shutil.copytree(kin / "lerobot", tmp_path / "plain")
    shares = [word for name, share in HALVES.items() for word in ("--share", f"{name}={share}")]

    def said(command, folders, out):
        options = shares if command == "split" else []
        answer = CliRunner().invoke(
            app, ["dataset", command, *map(str, folders), "--out", str(tmp_path / out), *options]
        )
        assert answer.exit_code == 0
        return answer.stdout

    alone = f"{plain}: no provenance: every episode was split by itself"
    assert alone in said("split", [plain], "parts")
    assert "no provenance" not in said("split", [kin / "lerobot"], "kin")
    lacking = f"{plain}: no provenance.parquet, keypoints.json, limits.json: what one dataset lacks, the whole lacks"
    assert lacking in said("merge", [kin, plain], "both")
    assert "lacks" not in said("merge", [kin, kin / "lerobot"], "twice")
