"""The work of stage segment_pool: read demonstrations, cut, draw, and check the pool."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from sim1.episode import Episode, episode_folders, read_episode
from sim1.motion.commands import Arms
from sim1.motion.pictures import draw_segmentation
from sim1.motion.pool import Segment, by_demo, read_pool
from sim1.motion.segments import Span, cut, grasp_vertices, interacting_frames
from sim1.progress import track
from sim1.scene.description import read_scene
from sim1.stage import BadInput, Finding

if TYPE_CHECKING:
    from sim1.motion.stage import SegmentPoolConfig


def cut_demos(demos: Path, scene: Path, garment: str, config: SegmentPoolConfig, out: Path) -> list[Segment]:
    """Segments of all demonstrations of `garment`, numbered through; a picture for each goes to `out`.

    Raises:
        BadInput: there is no demonstration, or none that succeeded has an interaction.
    """
    arms = Arms.of_scene(read_scene(scene))
    folders = episode_folders(demos)
    if not folders:
        raise BadInput(f"{demos}/episodes: no demonstration; make seed_demos again with more of them")
    segments: list[Segment] = []
    for folder in track(folders, "cutting demonstrations"):
        episode = read_episode(folder)
        spans, parts = cut_episode(episode, folder.name, garment, arms, config, len(segments))
        segments += parts
        measured = arms.tool_path(episode.joints_rad, episode.openness)
        draw_segmentation(out / f"segments_{folder.name}.png", folder.name, episode, measured, spans)
    if not any(part.kind == "interacting" and part.success for part in segments):
        raise BadInput(f"{demos}: no successful demonstration with an interaction; record one that succeeds")
    return segments


def cut_episode(
    episode: Episode, demo: str, garment: str, arms: Arms, config: SegmentPoolConfig, first: int
) -> tuple[list[Span], list[Segment]]:
    """Spans of one demonstration and the segments that they become, numbered from `first`."""
    measured = arms.tool_path(episode.joints_rad, episode.openness)
    commanded = arms.tool_path(episode.command_joints_rad, episode.command_openness)
    active = interacting_frames(episode.openness, measured.position_m, episode.garment_m, config)
    spans = cut(active.any(axis=1), config)
    counts = {"interacting": 0, "moving": 0}
    segments = []
    for span in spans:
        grasps = (-1, -1)
        if span.kind == "interacting":
            grasps = grasp_vertices(span, episode.openness, measured.position_m, episode.garment_m, config)
        segments.append(
            Segment(
                segment=first + len(segments),
                demo=demo,
                kind=span.kind,
                order=counts[span.kind],
                start_frame=span.start,
                end_frame=span.end,
                grasp_left=grasps[0],
                grasp_right=grasps[1],
                success=bool(episode.about.get("success", False)),
                garment=garment,
                joints_rad=episode.command_joints_rad[span.start : span.end],
                path=commanded[span.start : span.end],
            )
        )
        counts[span.kind] += 1
    return spans, segments


def pool_findings(artifact: Path) -> list[Finding]:
    """Answers of the stage's check."""
    demos = by_demo(read_pool(artifact))
    gaps, repeats, ungrasped = [], [], []
    for demo, parts in demos.items():
        ends = [0] + [part.end_frame for part in parts[:-1]]
        gaps += [f"{demo} frame {end}" for end, part in zip(ends, parts, strict=True) if end != part.start_frame]
        repeats += [demo for one, two in pairwise(parts) if one.kind == two.kind]
        ungrasped += [part.segment for part in parts if part.kind == "interacting" and not part.grasps]
    interactions = [sum(part.kind == "interacting" for part in parts) for parts in demos.values()]
    return [
        Finding(
            name="frames_covered_once",
            passed=not gaps,
            detail=f"gaps or overlaps: {', '.join(gaps) or 'none'}, in {len(demos)} demonstrations",
        ),
        Finding(
            name="kinds_alternate", passed=not repeats, detail=f"repeated kinds in: {', '.join(repeats) or 'none'}"
        ),
        Finding(
            name="every_demonstration_interacts",
            passed=min(interactions, default=0) > 0,
            detail=f"interactions per demonstration: {interactions}, at least 1 expected",
            blocking=False,  # a failed demonstration may never have touched the garment
        ),
        Finding(
            name="interactions_grasp",
            passed=not ungrasped,
            detail=f"interactions in which no arm closes on cloth: {ungrasped or 'none'}",
            blocking=False,  # pressing down or smoothing with closed fingers is legitimate
        ),
    ]
