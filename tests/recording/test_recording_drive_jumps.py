"""How far a drive may go in a step follows from how hard an arm can set off, and so from the time between samples."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sim1.recording.drive_jumps import check_path
from sim1.stage import BadInput


def checked(time_s, along_m, turn_rad=None, first_row=40):
    turn = np.zeros(len(time_s)) if turn_rad is None else turn_rad
    check_path(
        lambda at: f"recordings/a/drives.parquet: row {first_row + at}",
        time_s,
        np.column_stack([along_m, 0 * along_m, 0.8 + 0 * along_m]),
        Rotation.from_euler("y", turn[:, None]).as_quat(scalar_first=True),
    )


def clock(rate_hz, seconds=1.0):
    return np.arange(round(rate_hz * seconds)) / rate_hz


def step(time_s, size, samples=1):
    """Nothing, and from half of the time on `size`, reached in so many samples."""
    return size * np.clip((np.arange(len(time_s)) - len(time_s) // 2 + 1) / samples, 0.0, 1.0)


@pytest.mark.parametrize(("rate_hz", "samples"), [(20.0, 1), (60.0, 1), (60.0, 2), (100.0, 1), (100.0, 2), (500.0, 2)])
def test_a_jump_from_standstill_is_refused_with_row_value_and_remedy(rate_hz, samples):
    time = clock(rate_hz)
    said = r"drives\.parquet.*row \d+: the drive jumps by 0\.0\d+ m in .* s at .* m/s\^2.*repair the stream"
    with pytest.raises(BadInput, match=said):
        checked(time, step(time, 0.049, samples))
    with pytest.raises(BadInput, match=r"row \d+: the drive turns by 0\.\d+ rad .*repair the stream"):
        checked(time, 0 * time, step(time, np.radians(30.0), samples))


def test_the_row_is_that_of_the_sample_after_the_jump():
    time = clock(100.0)
    with pytest.raises(BadInput, match=r"row 90: the drive jumps by 0\.049 m in 0\.01 s at 0\.5 s"):
        checked(time, step(time, 0.049))


def test_a_jump_and_its_way_back_do_not_excuse_each_other():
    time = clock(100.0)
    away = np.where(np.arange(len(time)) == 50, 0.03, 0.0)
    with pytest.raises(BadInput, match="row 90: the drive jumps"):
        checked(time, away)


def test_a_jump_in_the_midst_of_a_motion_is_refused():
    time = clock(100.0)
    with pytest.raises(BadInput, match="jumps"):
        checked(time, 0.5 * time + step(time, 0.03))


@pytest.mark.parametrize("rate_hz", [20.0, 100.0, 500.0])
def test_an_arm_that_sets_off_and_brakes_hard_passes(rate_hz):
    """3 g to 1.5 m/s, a sudden stop in as short a time, and a wrist that turns with it by 20 rad/s."""
    time = clock(rate_hz)
    speed = np.minimum(np.clip(30.0 * (time - 0.3), 0.0, 1.5), np.clip(30.0 * (0.6 - time), 0.0, 1.5))
    along = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) / rate_hz)])
    checked(time, along, 13.0 * along)


def test_stamps_that_jitter_make_no_jump_of_a_motion():
    """Samples that arrive in bursts, half a millisecond and two tenths of a second apart, of a motion of 0.5 m/s."""
    time = clock(20.0, 4.0)
    late = np.where(np.arange(len(time)) % 2 == 0, 0.0495, 0.0)
    checked(time + late, 0.1 * np.sin(5.0 * time))


def test_a_still_drive_that_trembles_passes():
    time = clock(500.0)
    checked(time, 1e-3 * np.random.default_rng(0).standard_normal(len(time)))
