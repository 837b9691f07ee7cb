"""Time stamps of a stream: they increase, at a rate that a stream can have."""

from collections.abc import Callable

import numpy as np

from sim1.stage import BadInput

SLOWEST_S = 0.5  # median step: slower, and nothing of a motion is left, or the stamps are milliseconds
CLOSEST_S = 1e-8  # two samples closer than this are one, stamped twice; single precision alone leaves more
LONGEST_S = 3600.0
LATEST_S = 3600.0  # from the clock's origin: motion is foretold from 0 s on, and a recording is no hour long


def check_origin(place: Callable[[int], str], time_s: np.ndarray) -> None:
    """Check that the time stamps (n,) of one stream are finite and count from about its start; `place` is where a sample stands.

    Raises:
        BadInput: they are not, as those of a computer's clock.
    """
    if (bad := ~(np.abs(time_s) <= LATEST_S)).any():
        at = int(np.argmax(bad))
        raise BadInput(
            f"{place(at)}: time_s is {time_s[at]:.12g}; expected seconds from the start of the recording, at most {LATEST_S:g}: "
            "subtract one and the same stamp from both streams, and from from_s and to_s of the holds"
        )


def check_forward(place: Callable[[int], str], time_s: np.ndarray) -> None:
    """Check that the time stamps (n,) of one stream follow each other; `place` is where a sample stands.

    Raises:
        BadInput: the clock runs back.
    """
    if (back := np.diff(time_s) < 0).any():
        at = int(np.argmax(back)) + 1
        raise BadInput(
            f"{place(at)}: the clock runs back from {time_s[at - 1]} s to {time_s[at]} s; "
            "sort or repair the time stamps"
        )


def check_forward_by_marker(place: Callable[[int], str], time_s: np.ndarray, marker: np.ndarray) -> None:
    """Check that the rows of each marker follow its time, (n,) both: frame by frame or marker by marker, a clock that ran back is seen.

    Raises:
        BadInput: rows of a marker that go back in time.
    """
    rows = np.argsort(marker, kind="stable")
    back = (marker[rows][1:] == marker[rows][:-1]) & (np.diff(time_s[rows]) < 0)
    if back.any():
        before, after = (int(rows[int(np.argmax(back)) + k]) for k in (0, 1))
        raise BadInput(
            f"{place(after)}: the clock runs back from {time_s[before]} s to {time_s[after]} s for marker {marker[after]}; "
            "sort or repair the time stamps"
        )


def check_clock(place: Callable[[int], str], time_s: np.ndarray) -> None:
    """Check the time stamps (n,) of one stream; `place` is where a sample stands.

    Raises:
        BadInput: the clock stands, runs back, or counts something else than seconds.
    """
    check_forward(place, time_s)
    step = np.diff(time_s)
    if len(step) == 0:
        return
    if (same := step < CLOSEST_S).any():
        at = int(np.argmax(same)) + 1
        raise BadInput(
            f"{place(at)}: the clock stands still from {time_s[at - 1]} s to {time_s[at]} s; "
            "keep one sample of each time stamp"
        )
    if (usual := float(np.median(step))) > SLOWEST_S or time_s[-1] - time_s[0] > LONGEST_S:
        raise BadInput(
            f"{place(0)}: {len(time_s)} samples from {time_s[0]:.6g} to {time_s[-1]:.6g} s, {usual:.3g} s apart; "
            "expected seconds: are these milliseconds or frame numbers?"
        )
