"""`sim1 diagnose` on what is wrong with a lab's bundle: the file and the place in it are named, and there is no verdict."""

import re
import shutil

import numpy as np
import pandas as pd
import pytest
import yaml
from small_bundle import empty_bundle
from typer.testing import CliRunner

from assets_defs.cli import app
from sim1.recording.bundle import write_bundle

MARKERS, DRIVES = "recordings/swing_1/markers.parquet", "recordings/swing_1/drives.parquet"


def _table(file, edit):
    def do(folder):
        table = pd.read_parquet(folder / file)
        edit(table)
        table.to_parquet(folder / file, index=False)

    return do


def _set(row, column, value):
    def edit(table):
        table.loc[row, column] = value

    return edit


def _jump(table):
    table.loc[80:, "y_m"] += 0.3


def _millimetres(table):
    table[["x_m", "y_m", "z_m"]] *= 1000


def _one_recording(folder):
    content = yaml.safe_load((folder / "bundle.yaml").read_text())
    for part in content["recordings"][1:]:
        shutil.rmtree(folder / "recordings" / part["name"])
    content["recordings"] = content["recordings"][:1]
    (folder / "bundle.yaml").write_text(yaml.safe_dump(content))


def _back(table):
    table.loc[table["time_s"] > 1.0, "time_s"] -= 0.5


def _hidden_from(time_s):
    def do(table):
        late = table["time_s"] >= time_s
        table.loc[late, "visible"] = False
        table.loc[late, ["x_m", "y_m", "z_m"]] = np.nan

    return do


WRONG = {
    "a missing stream": (lambda folder: (folder / MARKERS).unlink(), ("swing_1/markers.parquet", "missing stream; expected")),
    "clocks that cross": (_table(MARKERS, _back), ("swing_1/markers.parquet", "row 976: the clock runs back")),
    "clocks apart": (_table(MARKERS, lambda t: t.__setitem__("time_s", t["time_s"] + 100)), ("swing_1", "overlap")),
    "a marker off the mesh": (_table("anchors.parquet", _set(3, "face", 9999)), ("anchors.parquet", "face 9999")),
    "millimetres": (_table(MARKERS, _millimetres), ("swing_1/markers.parquet", "millimetres")),
    "one recording only": (_one_recording, ("bundle.yaml", "record the cloth once more")),
    "nothing seen": (_table(MARKERS, lambda t: t.__setitem__("visible", False)), ("swing_1/markers.parquet", "no marker is visible")),
    "hidden while it moves": (_table(MARKERS, _hidden_from(0.55)), ("swing_1/markers.parquet", "0 % show 3 markers or more")),
    "NaN": (_table(MARKERS, _set(200, "x_m", np.nan)), ("swing_1/markers.parquet", "row 200")),
    "a drive that jumps": (_table(DRIVES, _jump), ("swing_1/drives.parquet", "row 80.*jumps")),
}  # fmt: skip


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wrong") / "good"
    write_bundle(folder, empty_bundle())
    return folder


@pytest.mark.parametrize("wrong", WRONG)
def test_wrong_input_is_named_and_gets_no_verdict(good, tmp_path, wrong):
    do, words = WRONG[wrong]
    bundle, out = shutil.copytree(good, tmp_path / "bundle"), tmp_path / "out"
    do(bundle)
    answer = CliRunner().invoke(app, ["diagnose", str(bundle), "--out", str(out)])
    said = " ".join(answer.output.split())
    assert answer.exit_code == 2, said
    for word in words:
        assert re.search(word, said), said
    assert not out.exists()


def test_an_earlier_verdict_survives_wrong_input(good, tmp_path):
    bundle, out = shutil.copytree(good, tmp_path / "bundle"), tmp_path / "out"
    out.mkdir()
    (out / "verdict.json").write_text("{}")
    WRONG["NaN"][0](bundle)
    assert CliRunner().invoke(app, ["diagnose", str(bundle), "--out", str(out)]).exit_code == 2
    assert (out / "verdict.json").read_text() == "{}"
