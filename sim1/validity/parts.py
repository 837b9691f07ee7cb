"""Who is trained on, who sets the threshold and who tests: clips dealt out by the demonstrations that they are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

SHARES = {"train": 0.6, "calibration": 0.2, "test": 0.2}  # of the clips of the rarer outcome


@dataclass(frozen=True, kw_only=True)
class LabelledClip:
    """A clip as the network sees it."""

    name: str
    frames: np.ndarray  # (t, h, w, 3) u8
    success: bool
    sources: frozenset[str]


@dataclass(frozen=True, kw_only=True)
class Parts:
    """No clip is in two of them, and none that is trained on goes back to a demonstration of the others."""

    train: list[LabelledClip]
    calibration: list[LabelledClip]  # the threshold is chosen on these
    test: list[LabelledClip]  # these have no say in network and threshold
    apart: bool  # calibration and test have no demonstration in common either


def split_by_source(clips: Sequence[LabelledClip]) -> Parts:
    """Deal the demonstrations out, and with them their clips; clips of two held-out parts are left aside.

    Those with most clips of the rarer outcome come first, to the part that has least of it for its share. Where calibration and
    test cannot both have both outcomes that way, they share their demonstrations, clip by clip. Where training would lack an
    outcome, nothing is held out.
    """
    home = _dealt(clips)
    inside = {part: {source for source, where in home.items() if where == part} for part in SHARES}
    held = [clip for clip in clips if clip.sources - inside["train"]]
    train = [clip for clip in clips if not clip.sources - inside["train"]]
    calibration = [clip for clip in held if not clip.sources & inside["test"]]
    test = [clip for clip in held if not clip.sources & inside["calibration"]]
    apart = _both(calibration) and _both(test)
    if not apart:
        calibration, test = _halves(held)
    if not _both(train):
        return Parts(train=list(clips), calibration=[], test=[], apart=False)
    return Parts(train=train, calibration=calibration, test=test, apart=apart)


def _dealt(clips: Sequence[LabelledClip]) -> dict[str, str]:
    """Part of each demonstration."""
    rarer = sum(clip.success for clip in clips) * 2 <= len(clips)  # success is
    own = {
        source: [clip for clip in clips if source in clip.sources]
        for source in set().union(*(c.sources for c in clips))
    }
    counts = {source: sum(clip.success is rarer for clip in some) for source, some in own.items()}
    have, home = dict.fromkeys(SHARES, 0.0), {}
    for source in sorted(own, key=lambda name: (-counts[name], -len(own[name]), name)):
        part = min(SHARES, key=lambda name: have[name] / SHARES[name])
        have[part] += counts[source] + 1e-3 * len(own[source])  # among demonstrations without any, all clips count
        home[source] = part
    return home


def _halves(clips: Sequence[LabelledClip]) -> tuple[list[LabelledClip], list[LabelledClip]]:
    """Every second clip of each outcome."""
    outcomes = [[clip for clip in clips if clip.success is wanted] for wanted in (True, False)]
    return [clip for some in outcomes for clip in some[::2]], [clip for some in outcomes for clip in some[1::2]]


def _both(clips: Sequence[LabelledClip]) -> bool:
    return len({clip.success for clip in clips}) == 2
