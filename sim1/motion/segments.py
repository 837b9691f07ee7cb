"""Demonstrations of any length cut into `interacting` and `moving` parts (paper, section DataGen).

An arm interacts while its gripper changes next to cloth, and while it is closed on cloth. The time line of both arms is cut together:
a frame is interacting when either arm is.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.ndimage import binary_closing, binary_dilation, binary_opening
from scipy.spatial import KDTree

from sim1.episode import RATE_HZ

type Kind = Literal["interacting", "moving"]


@dataclass(frozen=True, kw_only=True)
class SegmentationConfig:
    """Thresholds of the segmentation; times in seconds."""

    change_rate_per_s: float  # openness changes faster than this: the gripper works
    hold_below: float  # a gripper less open than this may hold cloth
    release_above: float  # hysteresis: it holds until it is wider open than this
    contact_m: float  # finger tips to nearest garment vertex, when closing on cloth
    margin_s: float  # approach and retreat that belong to an interaction
    minimum_s: float  # no segment is shorter


@dataclass(frozen=True, kw_only=True)
class Span:
    """Frames start (included) to end (excluded)."""

    kind: Kind
    start: int
    end: int


def interacting_frames(
    openness: np.ndarray, tool_m: np.ndarray, garment_m: np.ndarray, config: SegmentationConfig
) -> np.ndarray:
    """Which arm interacts at which frame: (T, 2) bool.

    Args:
        openness: (T, 2)
        tool_m: (T, 2, 3) finger tips.
        garment_m: (T, v, 3)
        config: thresholds.
    """
    result = np.abs(np.gradient(openness, 1 / RATE_HZ, axis=0)) > config.change_rate_per_s
    for arm in range(2):
        for frame in np.flatnonzero(result[:, arm]):  # a gripper that opens in the air on its way home touches nothing
            result[frame, arm] = _touches(tool_m[frame, arm], garment_m[frame], config)
        result[:, arm] |= _holding(openness[:, arm], tool_m[:, arm], garment_m, config)
    return result


def _touches(tool_m: np.ndarray, garment_m: np.ndarray, config: SegmentationConfig) -> bool:
    return bool(np.linalg.norm(garment_m - tool_m, axis=-1).min() < config.contact_m)


def _holding(openness: np.ndarray, tool_m: np.ndarray, garment_m: np.ndarray, config: SegmentationConfig) -> np.ndarray:
    """Closed on cloth, with hysteresis: it starts at a contact and lasts until the gripper opens."""
    held = np.zeros(len(openness), bool)
    holds = False
    for frame, value in enumerate(openness):
        if holds:
            holds = value < config.release_above
        elif value < config.hold_below:
            holds = _touches(tool_m[frame], garment_m[frame], config)
        held[frame] = holds
    return held


def cut(interacting: np.ndarray, config: SegmentationConfig) -> list[Span]:
    """Alternating spans that cover every frame of `interacting` (T,) bool once.

    Interactions are widened by the margin, gaps shorter than the minimum are closed, and what is still shorter than
    the minimum belongs to its neighbours.
    """
    margin, minimum = round(config.margin_s * RATE_HZ), max(round(config.minimum_s * RATE_HZ), 1)
    mask = binary_dilation(interacting, np.ones(2 * margin + 1, bool)) if interacting.any() else interacting
    pad = len(mask)  # a mask's ends count as continued, so that nothing is eaten from outside
    wide = np.pad(mask, minimum, mode="edge")
    wide = binary_opening(binary_closing(wide, np.ones(minimum, bool)), np.ones(minimum, bool))
    mask = wide[minimum : minimum + pad]
    edges = np.flatnonzero(np.diff(mask)) + 1
    bounds = [0, *edges.tolist(), len(mask)]
    return [
        Span(kind="interacting" if mask[start] else "moving", start=start, end=end) for start, end in pairwise(bounds)
    ]


def grasp_vertices(span: Span, openness: np.ndarray, tool_m: np.ndarray, garment_m: np.ndarray, config: SegmentationConfig) -> tuple[int, int]:  # fmt: skip
    """Vertex nearest to each arm's finger tips when it closes within the span, -1 where that arm grasps nothing."""
    result = []
    for arm in range(2):
        holds = _holding(openness[:, arm], tool_m[:, arm], garment_m, config)[span.start : span.end]
        if not holds.any():
            result.append(-1)
            continue
        frame = span.start + int(np.argmax(holds))
        result.append(int(KDTree(garment_m[frame]).query(tool_m[frame, arm])[1]))
    return result[0], result[1]
