"""What the store holds of a garment's demonstrations and candidates, as clips, as features, and as the judge saw them."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

from sim1.cloth.garment import read_garment_mesh
from sim1.episode import episode_folders
from sim1.robot.expert_task import read_task
from sim1.scene.description import read_scene
from sim1.validity.clips import sampled
from sim1.validity.examples import read_examples, reference_of
from sim1.validity.features import episode_features
from sim1.validity.parts import LabelledClip
from sim1.validity.raster import render_head_view
from sim1.validity.stage import VideoDiscriminatorConfig
from sim1.validity.success import CUT_SHORT, fold_excess

NEEDED = ("seed_demos", "candidate_trajectories", "garment_mesh", "scene")


def drawn(paths: dict[str, Path], config: VideoDiscriminatorConfig) -> tuple[list[LabelledClip], pd.DataFrame]:
    """Clips of all demonstrations and candidates in the head view, drawn anew: of any number of frames of any size. And their
    features, as rules see them, by name of clip.

    Raises:
        BadInput: an episode is damaged.
    """
    mesh, scene = read_garment_mesh(paths["garment_mesh"]), read_scene(paths["scene"])
    reference, clips, rows = reference_of(mesh, paths["seed_demos"]), [], {}
    for item in read_examples(paths["seed_demos"], paths["candidate_trajectories"], "clips"):
        shapes_m = sampled(item.episode.garment_m, config.frame_count)
        size = config.frame_width, config.frame_height
        frames = [render_head_view(shape, mesh.faces, scene, *size) for shape in shapes_m]
        clips.append(LabelledClip(name=item.name, frames=np.stack(frames), success=item.success, sources=item.sources))
        rows[item.name] = episode_features(item.episode.garment_m, reference)
    return clips, pd.DataFrame.from_dict(rows, orient="index")


def judged(demos: Path, candidates: Path) -> dict[str, tuple[str | None, float]]:
    """Of each clip by name: its class of failure, None where it folds, and how far its fold is beyond the judge's limits.

    Raises:
        BadInput: the task cannot be read.
    """
    limits, found = read_task(demos / "task.json").success, {}
    for kind, folder in (("demo", demos), ("candidate", candidates)):
        for episode in episode_folders(folder):
            about = json.loads((episode / "episode.json").read_text())
            if about["failure"] not in CUT_SHORT:  # of which there are no clips, and of the judge no figures
                found[f"{kind}/{episode.name}"] = (about["failure"], fold_excess(about["figures"], limits))
    return found
