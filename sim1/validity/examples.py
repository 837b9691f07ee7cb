"""Episodes with a known outcome: the positive and negative examples from which the filters learn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.cloth.garment import GarmentMesh, face_areas, unique_edges
from sim1.episode import Episode, episode_folders, read_episode, read_start
from sim1.progress import track
from sim1.robot.expert_task import find_keypoints, read_task
from sim1.stage import BadInput
from sim1.validity.features import Reference
from sim1.validity.success import CUT_SHORT


@dataclass(frozen=True, kw_only=True)
class Example:
    """A demonstration or a candidate."""

    name: str  # demo/0000 or candidate/0000
    folder: Path
    episode: Episode
    success: bool
    sources: frozenset[str]  # demonstrations that it is made of
    perturbed: bool


def read_examples(demos: Path, candidates: Path, what: str, without: frozenset[str] = CUT_SHORT) -> Iterator[Example]:
    """Episodes of both, demonstrations first, but for those with a failure of `without`; with progress on `what`.

    One by one, as all of them together fill a memory.

    Raises:
        BadInput: an episode is damaged, or a candidate does not say which demonstrations it is made of.
    """
    folders = [("demo", folder) for folder in episode_folders(demos)]
    folders += [("candidate", folder) for folder in episode_folders(candidates)]
    for kind, folder in track(folders, what):
        example = _example(kind, folder)
        if example.episode.about.get("failure") not in without:
            yield example


def _example(kind: str, folder: Path) -> Example:
    episode = read_episode(folder)
    sources = [folder.name] if kind == "demo" else episode.about.get("sources")
    if not sources or not isinstance(sources, list):
        raise BadInput(
            f"{folder}/episode.json: sources is {sources!r}, expected the demonstrations that the candidate is made of; "
            "make candidate_trajectories again"
        )
    return Example(
        name=f"{kind}/{folder.name}",
        folder=folder,
        episode=episode,
        success=bool(episode.about.get("success", False)),
        sources=frozenset(map(str, sources)),
        perturbed=bool(episode.about.get("perturbed", False)),
    )


def reference_of(mesh: GarmentMesh, demos: Path) -> Reference:
    """What features are measured against: rest shape, and the task's keypoints on the settled garment.

    Raises:
        BadInput: a file is missing or damaged.
    """
    start = read_start(demos)
    edges = unique_edges(mesh.faces)
    return Reference(
        faces=mesh.faces,
        edges=edges,
        rest_length_m=np.linalg.norm(mesh.rest_m[edges[:, 1]] - mesh.rest_m[edges[:, 0]], axis=-1),
        rest_area_m2=float(face_areas(mesh.rest_m, mesh.faces).sum()),
        start_m=start,
        keypoints=find_keypoints(start, read_task(demos / "task.json")),
    )
