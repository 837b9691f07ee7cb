"""Whatever is done to a bundle, the reader gives a bundle or says in one line which file is at fault."""

import shutil
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_recording_bundle import DRIVES, FRAMES, MARKERS, SAMPLES, change, change_yaml, small_bundle

from sim1.recording.bundle import read_bundle, write_bundle
from sim1.stage import BadInput

ANCHORS = "anchors.parquet"
FILES = ["bundle.yaml", "garment.obj", ANCHORS, MARKERS, DRIVES]
ANY_FILE = r"bundle\.yaml|garment\.obj|anchors\.parquet|markers\.parquet|drives\.parquet"
NUMBERS = {
    ANCHORS: ["b0", "b1", "b2"],
    MARKERS: ["time_s", "x_m", "y_m", "z_m"],
    DRIVES: ["time_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz", "open"],
}
ROWS = {ANCHORS: 3, MARKERS: 3 * FRAMES, DRIVES: SAMPLES}
HIDDEN = 3 * 3 + 1  # the one row of markers.parquet that is not visible

often = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    folder = tmp_path_factory.mktemp("damage") / "good"
    write_bundle(folder, small_bundle())
    return folder


@pytest.fixture
def folder(good, tmp_path):
    return Path(shutil.copytree(good, tmp_path / "b"))


@contextmanager
def damaged(folder: Path, file: str):
    whole = (folder / file).read_bytes()
    try:
        yield folder / file
    finally:
        (folder / file).write_bytes(whole)


def refused_by_name(folder: Path, words: str = ANY_FILE) -> None:
    with pytest.raises(BadInput, match=words):
        read_bundle(folder)


def read_or_refused_by_name(folder: Path) -> bool:
    """Whether it was refused; then one of the files was named."""
    try:
        read_bundle(folder)
    except BadInput as error:
        said = str(error)
    else:
        return False
    assert any(Path(file).name in said for file in FILES), said
    return True


def test_names_may_be_written_once_each(folder):
    """As pandas and polars write columns of a few names."""
    table = pd.read_parquet(folder / DRIVES)
    table.astype({"drive": "category"}).to_parquet(folder / DRIVES)
    assert set(read_bundle(folder).recordings[0].drives) == set(table["drive"])


@often
@given(data=st.data(), file=st.sampled_from(list(NUMBERS)))
def test_no_absurd_number_gets_through(folder, data, file):
    row = data.draw(st.integers(0, ROWS[file] - 1).filter(lambda row: (file, row) != (MARKERS, HIDDEN)), "row")
    column = data.draw(st.sampled_from(NUMBERS[file]), "column")
    value = data.draw(st.sampled_from([np.nan, np.inf, -np.inf, 1e6, -1e6, 1e300, -1e300]), "value")
    with damaged(folder, file) as path:
        table = pd.read_parquet(path).astype({column: float})
        table.loc[row, column] = value
        table.to_parquet(path, index=False)
        refused_by_name(folder)


def test_what_stands_in_a_row_that_is_not_visible_does_not_matter(folder):
    before = read_bundle(folder).recordings[1].markers_m

    def fill(table):
        table.loc[HIDDEN, ["x_m", "y_m", "z_m"]] = [1e30, np.inf, 0.0]

    change(folder / MARKERS, fill)
    np.testing.assert_array_equal(read_bundle(folder).recordings[1].markers_m, before)


KINDS = {
    "text": lambda column: column.astype(str),
    "truth values": lambda column: np.arange(len(column)) % 2 == 0,
    "complex": lambda column: column.map(lambda _: [1.0, 2.0]),
    "dates": lambda column: pd.to_datetime(np.arange(len(column))),
    "nothing": lambda column: [None] * len(column),
    "bytes": lambda column: [b"\xff"] * len(column),
    "empty cells": lambda column: pd.array([None, *[1] * (len(column) - 1)], dtype="Int64"),
    "empty truth": lambda column: pd.array([None, *[True] * (len(column) - 1)], dtype="boolean"),
    "categories": lambda column: column.astype(str).astype("category"),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("file", [ANCHORS, MARKERS, DRIVES])
def test_a_column_of_another_kind_is_refused_by_name(folder, file, kind):
    whole = pd.read_parquet(folder / file)
    for name in whole.columns:
        if name == "drive" and kind in ("text", "categories"):
            continue
        whole.assign(**{name: KINDS[kind](whole[name])}).to_parquet(folder / file, index=False)
        if name == "visible" and kind == "truth values":
            read_or_refused_by_name(folder)
        else:
            refused_by_name(folder, rf"{Path(file).name}.*('{name}'|no row|not a name)")


@pytest.mark.parametrize("name", ["category", "string", "Float32", "float32"])
def test_the_same_values_in_another_storage_are_the_same_bundle(folder, name):
    names = ["drive"] if name in ("category", "string") else NUMBERS[DRIVES]
    change(folder / DRIVES, lambda table: table.astype(dict.fromkeys(names, name)))
    ours, back = small_bundle().recordings[1].drives["left"], read_bundle(folder).recordings[1].drives["left"]
    np.testing.assert_allclose(back.position_m, ours.position_m, atol=1e-6)


@often
@given(data=st.data(), file=st.sampled_from([ANCHORS, MARKERS, DRIVES]))
def test_rows_and_columns_lost_doubled_or_mixed_never_pass_in_silence(folder, data, file):
    whole = pd.read_parquet(folder / file)
    row = data.draw(st.integers(0, len(whole) - 1), "row")
    column = data.draw(st.sampled_from(list(whole.columns)), "column")
    change_of = {
        "row doubled": pd.concat([whole, whole.iloc[[row]]]),
        "column lost": whole.drop(columns=column),
        "column renamed": whole.rename(columns={column: column + "m"}),
        "column added": whole.assign(force_n=1.0),
        "rows backwards": whole.iloc[::-1],
        "no rows": whole.iloc[:0],
    }
    if file != DRIVES:
        change_of["row lost"] = whole.drop(index=row)
    what = data.draw(st.sampled_from(sorted(change_of)), "what")
    with damaged(folder, file) as path:
        change_of[what].to_parquet(path, index=False)
        if what == "rows backwards" and file == ANCHORS:
            read_bundle(folder)  # anchors are no series
        else:
            refused_by_name(folder, Path(file).name if what != "row lost" else ANY_FILE)


def test_scrambled_bytes_are_read_or_refused_by_name(folder):
    refused = []

    @often
    @given(data=st.data(), file=st.sampled_from(FILES))
    def scramble(data, file):
        whole = bytearray((folder / file).read_bytes())
        if data.draw(st.booleans(), "cut"):
            del whole[data.draw(st.integers(0, len(whole) - 1), "from") :]
        else:
            for _ in range(data.draw(st.integers(1, 8), "count")):
                whole[data.draw(st.integers(0, len(whole) - 1), "at")] = data.draw(st.integers(0, 255), "byte")
        with damaged(folder, file) as path:
            path.write_bytes(bytes(whole))
            refused.append(read_or_refused_by_name(folder))

    scramble()
    assert sum(refused) > len(refused) / 2  # some bytes do not matter; nine in ten of the damages do


@pytest.mark.parametrize("file", FILES)
def test_a_file_that_is_cut_in_half_or_empty_is_refused_by_its_own_name(folder, file):
    whole = (folder / file).read_bytes()
    for left in (len(whole) // 2, 0):
        (folder / file).write_bytes(whole[:left])
        refused_by_name(folder, file.replace(".", r"\."))


def _leaves(content, place=()):
    pairs = content.items() if isinstance(content, dict) else enumerate(content) if isinstance(content, list) else ()
    found = [(*place, key) for key, _ in pairs]
    return found + [deeper for key, value in pairs for deeper in _leaves(value, (*place, key))]


ODD = st.sampled_from(
    [
        None,
        True,
        "",
        "x",
        "../..",
        -1,
        0,
        10**30,
        -1e300,
        1e300,
        1e-300,
        [],
        {},
        [[]],
        [True],
        ["a"],
        {"a": 1},
        "\x00",
        "é",
    ]
)


def test_odd_values_in_bundle_yaml_are_read_or_refused_by_name(folder):
    places, refused = _leaves(yaml.safe_load((folder / "bundle.yaml").read_text())), []

    @often
    @given(place=st.sampled_from(places), value=ODD, drop=st.booleans())
    def exchange(place, value, drop):
        def edit(content):
            for key in place[:-1]:
                content = content[key]
            if drop:
                del content[place[-1]]
            else:
                content[place[-1]] = value

        with damaged(folder, "bundle.yaml"):
            change_yaml(folder, edit)
            refused.append(read_or_refused_by_name(folder))

    exchange()
    assert sum(refused) > len(refused) / 2  # a name may be "x", and a key that may be absent may be dropped


def test_odd_words_in_the_mesh_are_read_or_refused_by_name(folder):
    lines, refused = (folder / "garment.obj").read_text().splitlines(), []
    odd = ["nan", "inf", "1e400", "1e300", "-1", "0", "9" * 25, "1/", "/1", "1//1", "x", "1/1/1", "0.3", "v", "f", ""]

    @often
    @given(data=st.data(), new=st.sampled_from(odd))
    def exchange(data, new):
        row = data.draw(st.integers(0, len(lines) - 1), "line")
        words = lines[row].split()
        words[data.draw(st.integers(0, len(words) - 1), "word")] = new
        with damaged(folder, "garment.obj") as path:
            path.write_text("\n".join([*lines[:row], " ".join(words), *lines[row + 1 :]]) + "\n")
            refused.append(read_or_refused_by_name(folder))

    exchange()
    assert sum(refused) > len(refused) / 2  # a new number may be a good one
