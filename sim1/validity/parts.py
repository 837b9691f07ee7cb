"""Who is trained on, who sets the threshold and who tests: clips dealt out by the demonstrations that they are made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
    """No clip is in two of them, and no two of them have a demonstration in common."""

    train: list[LabelledClip]
    calibration: list[LabelledClip]  # the threshold is chosen on these
    test: list[LabelledClip]  # these have no say in network and threshold
    left_out: list[LabelledClip]  # made of demonstrations of several parts


def split_by_source(clips: Sequence[LabelledClip]) -> Parts:
    """Deal clips out by `SHARES`. Where training would lack an outcome, nothing is held out.

    Calibration or test may lack one: that is for whoever uses them to see.
    """
    dealt, left_out = deal(clips, SHARES)
    if len({clip.success for clip in dealt["train"]}) < 2:
        return Parts(train=list(clips), calibration=[], test=[], left_out=[])
    return Parts(**dealt, left_out=left_out)


def deal[Part](
    clips: Sequence[LabelledClip], shares: Mapping[Part, float]
) -> tuple[dict[Part, list[LabelledClip]], list[LabelledClip]]:
    """Deal the demonstrations out, and with them the clips that are made of those of one part alone; the others are left out.

    Demonstrations with most clips of the rarer outcome come first, to the part that has least of it for its share.
    """
    home = _homes(clips, shares)
    dealt: dict[Part, list[LabelledClip]] = {part: [] for part in shares}
    left_out = []
    for clip in clips:
        parts = {home[source] for source in clip.sources}
        (dealt[parts.pop()] if len(parts) == 1 else left_out).append(clip)
    return dealt, left_out


def _homes[Part](clips: Sequence[LabelledClip], shares: Mapping[Part, float]) -> dict[str, Part]:
    """Part of each demonstration."""
    rarer = sum(clip.success for clip in clips) * 2 <= len(clips)  # success is
    own = {
        source: [clip for clip in clips if source in clip.sources]
        for source in set().union(*(c.sources for c in clips))
    }
    counts = {source: sum(clip.success is rarer for clip in some) for source, some in own.items()}
    have, home = dict.fromkeys(shares, 0.0), {}
    for source in sorted(own, key=lambda name: (-counts[name], -len(own[name]), name)):
        part = min(shares, key=lambda name: have[name] / shares[name])
        have[part] += counts[source] + 1e-3 * len(own[source])  # among demonstrations without any, all clips count
        home[source] = part
    return home
