"""Time stamps of a stream: they increase, at a rate that a stream can have."""

from collections.abc import Callable

import numpy as np

from sim1.stage import BadInput

SLOWEST_S = 0.5  # median step: slower, and nothing of a motion is left, or the stamps are milliseconds
CLOSEST_S = 1e-8  # two samples closer than this are one, stamped twice; single precision alone leaves more
LONGEST_S = 3600.0
LATEST_S = 3600.0  # from the clock's origin: motion is foretold from 0 s on, and a recording is no hour long


def check_origin(place: str, time_s: np.ndarray, row_of: Callable[[int], int]) -> None:
    """Check that the time stamps (n,) of one stream are finite and count from about its start.

    Raises:
        BadInput: they are not, as those of a computer's clock.
    """
    if (bad := ~(np.abs(time_s) <= LATEST_S)).any():
        at = int(np.argmax(bad))
        raise BadInput(
            f"{place}: row {row_of(at)}: time_s is {time_s[at]:.12g}; expected seconds from the start of the recording, at most {LATEST_S:g}: "
            "subtract one and the same stamp from both streams, and from from_s and to_s of the holds in bundle.yaml"
        )


def check_clock(place: str, time_s: np.ndarray, row_of: Callable[[int], int]) -> None:
    """Check the time stamps (n,) of one stream; `place` starts messages, `row_of` gives the row of a sample in the file.

    Raises:
        BadInput: the clock stands, runs back, or counts something else than seconds.
    """
    step = np.diff(time_s)
    if len(step) == 0:
        return
    if (back := step < 0).any():
        at = int(np.argmax(back)) + 1
        raise BadInput(
            f"{place}: row {row_of(at)}: the clock runs back from {time_s[at - 1]} s to {time_s[at]} s; "
            "sort or repair the time stamps"
        )
    if (same := step < CLOSEST_S).any():
        at = int(np.argmax(same)) + 1
        raise BadInput(
            f"{place}: row {row_of(at)}: the clock stands still from {time_s[at - 1]} s to {time_s[at]} s; "
            "keep one sample of each time stamp"
        )
    if (usual := float(np.median(step))) > SLOWEST_S or time_s[-1] - time_s[0] > LONGEST_S:
        raise BadInput(
            f"{place}: row {row_of(0)}: {len(time_s)} samples from {time_s[0]:.6g} to {time_s[-1]:.6g} s, {usual:.3g} s apart; "
            "expected seconds: are these milliseconds or frame numbers?"
        )
