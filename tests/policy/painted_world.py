"""A towel's trajectories and their dataset, its frames painted where Blender would render them."""

import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import yaml
from PIL import Image
from towel_cell import episode, write_inputs

from sim1.dataset.stage import DatasetConfig, dataset
from sim1.episode import write_episode
from sim1.policy.image.policy_file import SCHEMA
from sim1.render.job import Job
from sim1.render.stage import RenderConfig, rendered_episodes
from sim1.stage import Inputs

ROBOT = {"": Path(__file__).parents[2] / "data" / "robot"}
POLICIES = Path(__file__).parents[2] / "data" / "policies"
SOURCES = {
    "0000": "0000",
    "0001": "0000",
    "0002": "0000",
    "0003": "0001",
    "0004": "0000",
}  # trajectory -> demonstration
HELD_OUT = "0003"  # the only one of its demonstration
MITE = {
    "pretrained_backbone_weights": None, "dim_model": 16, "n_heads": 2, "dim_feedforward": 16, "n_encoder_layers": 1,
    "use_vae": False,
}  # fmt: skip
RENDER = RenderConfig(width=32, height=24, samples=1, rate_hz=10, variants=2, device="cpu")


@dataclass
class Painter:
    """In place of Blender: a picture tells fabric, light and camera of its look, and the frame's number."""

    painted: int = 0

    def __call__(self, folder: Path, out: Path) -> None:
        job = Job.read(folder)
        width, height = job.settings["width"], job.settings["height"]
        for clip, camera, frame in job.frames():
            path = job.frame_path(out, clip, camera, frame)
            if path.exists():
                continue
            look = clip.appearance
            image = np.full((height, width, 3), 255 * np.array(look.fabric.colors[0]))
            image[: height // 3] = 255 * np.mean(
                [light.color for light in (*look.room.glows, *look.room.lamps)], axis=0
            )
            image[-3:, : max(1, round(width * (0.5 + look.elevation_offset_rad)))] = 255
            image[height // 2 :, frame : frame + 3] = (250, 250, 0)
            path.parent.mkdir(parents=True, exist_ok=True)
            Image.fromarray(image.clip(0, 255).astype(np.uint8)).save(path)
            self.painted += 1


def write_mite(folder: Path) -> Inputs:
    """The input `policies`: a very small one, `mite`."""
    folder.mkdir()
    text = {"schema": SCHEMA, "title": "A very small ACT", "type": "act", "settings": MITE}
    (folder / "mite.yaml").write_text(yaml.safe_dump(text))
    return {"policies": {"": folder}}


def write_world(folder: Path, *, sources: dict[str, str] = SOURCES, frame_count: int = 25) -> Inputs:
    """Inputs of stage `image_policy`; Blender must have been replaced."""
    inputs = write_inputs(folder)
    trajectories = inputs["valid_trajectories"]["towel"]
    shutil.rmtree(trajectories / "episodes")
    for place, (name, source) in enumerate(sources.items()):
        motion = episode(frame_count)
        shifted = replace(
            motion,
            joints_rad=motion.joints_rad + 0.05 * place,
            command_joints_rad=motion.command_joints_rad + 0.05 * place,
            about={**motion.about, "seed": place, "sources": [source]},
        )
        write_episode(trajectories / "episodes" / name, shifted)
    rendered, data = folder / "rendered", folder / "dataset"
    rendered.mkdir()
    data.mkdir()
    rendered_episodes(inputs, rendered, RENDER)
    dataset({"robot": ROBOT, "rendered_episodes": {"towel": rendered}}, data, DatasetConfig())
    return {
        "dataset": {"": data},
        "rendered_episodes": {"towel": rendered},
        "garment_mesh": inputs["garment_mesh"],
        "scene": inputs["scene"],
        "policies": {"": POLICIES},
        "appearance": inputs["appearance"],
    }
