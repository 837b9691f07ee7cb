"""Damaged NPZ files are refused with file, array, value and remedy, by everything that reads them."""

import json
import re

import numpy as np
import pytest

from sim1.array_file import read_arrays, read_numbers
from sim1.cloth.garment import read_garment_mesh
from sim1.episode import SCHEMA, Episode, read_episode, read_start, write_episode
from sim1.stage import BadInput
from sim1.validity.clips import Clip, read_clip, write_clip


def damaged_in(path, array):
    """One byte of the data of an array is another one."""
    content = bytearray(path.read_bytes())
    at = content.index(f"{array}.npy".encode()) + 200
    content[at] ^= 0xFF
    path.write_bytes(content)


def test_arrays_come_back(tmp_path):
    np.savez(tmp_path / "a.npz", one=np.arange(3), two=np.ones((3, 2)))
    arrays = read_numbers(tmp_path / "a.npz", {"one": ("n",), "two": ("n", 2)})
    np.testing.assert_array_equal(arrays["one"], np.arange(3))
    assert set(read_arrays(tmp_path / "a.npz", ("one",))) == {"one", "two"}


@pytest.mark.parametrize("share", [0.0, 0.02, 0.3, 0.7, 0.99])
@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_a_file_cut_short_anywhere_is_named_with_the_remedy(tmp_path, share, save):
    path = tmp_path / "a.npz"
    save(path, one=np.random.default_rng(0).normal(size=(50, 3)), two=np.zeros(9))
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    with pytest.raises(BadInput, match=re.escape(f"{path}: damaged, not a readable NPZ file (") + ".*; make it again"):
        read_arrays(path, ("one",))


def test_the_array_in_which_a_file_is_damaged_is_named(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, one=np.zeros(9), two=np.arange(90.0))
    damaged_in(path, "two")
    with pytest.raises(BadInput, match=r"a\.npz: damaged, .*array 'two': Bad CRC-32"):
        read_arrays(path, ("one", "two"))


@pytest.mark.parametrize(
    ("arrays", "said"),
    [
        ({"one": np.zeros(3)}, r"no array 'two', only \['one'\]"),
        ({"one": np.zeros(3), "two": np.array(["a"] * 3)}, r"array 'two' holds <U1, expected numbers"),
        ({"one": np.zeros(3), "two": np.zeros((4, 2))}, r"array 'two' is \(4, 2\), expected \(3, 2\)"),
        ({"one": np.zeros(3), "two": np.zeros(())}, r"array 'two' is \(\), expected \(3, 2\)"),
        ({"one": np.array([0, np.inf, 0]), "two": np.zeros((3, 2))}, r"array 'one' is inf at \(1,\), expected finite"),
        ({"one": np.array([None]), "two": np.zeros((1, 2))}, r"array 'one': Object arrays cannot be loaded"),
    ],
)
def test_what_does_not_fit_is_named_with_its_value(tmp_path, arrays, said):
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(BadInput, match=rf"a\.npz: .*{said}.*; make the garment again"):
        read_numbers(tmp_path / "a.npz", {"one": ("n",), "two": ("n", 2)}, remedy="make the garment again")


def test_an_npy_file_under_the_name_of_an_npz_is_damaged(tmp_path):
    with (tmp_path / "a.npz").open("wb") as file:
        np.save(file, np.zeros(3))
    with pytest.raises(BadInput, match=r"a\.npz: damaged"):
        read_arrays(tmp_path / "a.npz", ("one",))


def an_episode(**arrays):
    usual = {
        "time_s": np.arange(4) / 30, "joints_rad": np.zeros((4, 2, 6)), "openness": np.ones((4, 2)),
        "command_joints_rad": np.zeros((4, 2, 6)), "command_openness": np.ones((4, 2)), "garment_m": np.zeros((4, 5, 3)),
    }  # fmt: skip
    return Episode(**usual | arrays)


def test_a_truncated_file_of_every_reader_is_bad_input(tmp_path):
    """As a full disk or a copy that was broken off leaves it."""
    write_episode(tmp_path, an_episode())
    write_clip(tmp_path, Clip(frames=np.zeros((4, 6, 8, 3), np.uint8), rate_hz=10.0))
    np.savez(tmp_path / "start.npz", garment_m=np.zeros((5, 3)))
    np.savez(tmp_path / "mesh.npz", vertices_m=np.zeros((3, 3)), faces=np.array([[0, 1, 2]]), rest_m=np.eye(3))
    readers = {"episode": read_episode, "video": read_clip, "start": read_start, "mesh": read_garment_mesh}
    for name, read in readers.items():
        path = tmp_path / f"{name}.npz"
        read(tmp_path)
        path.write_bytes(path.read_bytes()[:-30])
        with pytest.raises(BadInput, match=rf"{name}\.npz: damaged, .* again$"):
            read(tmp_path)


def test_an_episode_whose_arrays_do_not_fit_is_refused_by_name(tmp_path):
    write_episode(tmp_path, an_episode(openness=np.ones((3, 2))))
    with pytest.raises(BadInput, match=r"episode\.npz: array 'openness' is \(3, 2\), expected \(4, 2\); make it again"):
        read_episode(tmp_path)


@pytest.mark.parametrize("text", ["[1]", "{", "{}", json.dumps({"schema": SCHEMA[:-1] + "9"})])
def test_an_episode_that_does_not_say_what_it_is_is_refused(tmp_path, text):
    write_episode(tmp_path, an_episode())
    (tmp_path / "episode.json").write_text(text)
    with pytest.raises(BadInput, match=r"episode\.json: .*; make it again"):
        read_episode(tmp_path)
