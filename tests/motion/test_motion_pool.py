"""The pool of segments on disk."""

from dataclasses import replace

import numpy as np
import pytest

from sim1.motion.pool import read_pool, write_pool
from sim1.stage import BadInput


def test_a_pool_reads_back_as_it_was_written(pool, tmp_path):
    write_pool(tmp_path, pool)
    back = read_pool(tmp_path)
    assert [part.segment for part in back] == [part.segment for part in pool]
    np.testing.assert_array_equal(back[1].path.position_m, pool[1].path.position_m)
    assert back[1].grasps == [0, 1]


def test_a_damaged_pool_is_refused_with_its_file(pool, tmp_path):
    write_pool(tmp_path, pool)
    (tmp_path / "segments.npz").write_bytes(b"no longer a zip")
    with pytest.raises(BadInput, match=str(tmp_path)):
        read_pool(tmp_path)


def test_a_pool_cut_short_or_of_other_frames_is_refused_with_what_to_do(pool, tmp_path):
    write_pool(tmp_path, pool)
    whole = (tmp_path / "segments.npz").read_bytes()
    (tmp_path / "segments.npz").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(
        BadInput, match=r"segments\.npz: damaged, not a readable segment pool .*make segment_pool again"
    ):
        read_pool(tmp_path)
    write_pool(tmp_path, [replace(pool[0], joints_rad=pool[0].joints_rad[:-1]), *pool[1:]])
    with pytest.raises(
        BadInput, match=r"array '0000\.joints_rad' is \(39, 2, 6\), expected \(40, 2, 6\); make segment_pool"
    ):
        read_pool(tmp_path)
