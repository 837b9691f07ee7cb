"""Reads the artifacts of `rendered_episodes`: one clip per episode and appearance."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sim1.array_file import read_numbers
from sim1.episode import Episode, episode_folders, read_episode
from sim1.render.appearance_file import read_about
from sim1.stage import BadInput

GARMENT = "garment.npz"
CAMERA = ("width", "height", "fy_px", "camera_to_world", "moves")  # what appearance.json says of each


@dataclass(frozen=True, kw_only=True)
class RenderedClip:
    """One episode of a garment in one appearance."""

    garment: str
    trajectory: str  # name of the episode's folder
    appearance: int
    folder: Path  # holds a folder per camera and appearance.json
    about: dict[str, Any]  # appearance.json
    rest_m: np.ndarray  # (v, 3) rest shape of the garment
    episode: Path

    @property
    def mesh(self) -> Path:
        """File with `rest_m`."""
        return self.episode.parents[1] / GARMENT

    @property
    def rate_hz(self) -> float:
        return self.about["rate_hz"]

    @property
    def stride(self) -> int:
        """Episode frames per rendered frame."""
        return self.about["stride"]

    @property
    def cameras(self) -> dict[str, dict[str, Any]]:
        return self.about["cameras"]

    def frames(self, camera: str) -> list[Path]:
        return sorted((self.folder / camera).glob("*.png"))

    def read_episode(self) -> Episode:
        return read_episode(self.episode)


def read_clips(artifact: Path, garment: str) -> list[RenderedClip]:
    """Clips of one artifact, by episode, then appearance.

    Raises:
        BadInput: a file is missing, unreadable or of another schema, or the number of frames is not what appearance.json says.
    """
    garment_file = read_numbers(artifact / GARMENT, {"rest_m": ("v", 3)}, "garment", "render the episodes again")
    rest_m = garment_file["rest_m"]
    clips = []
    for episode in episode_folders(artifact):
        for path in sorted(episode.glob("v*/appearance.json"), key=lambda path: int(path.parent.name[1:])):
            try:
                about = read_about(path)
                clip = RenderedClip(
                    garment=garment,
                    trajectory=episode.name,
                    appearance=int(path.parent.name[1:]),
                    folder=path.parent,
                    about=about,
                    rest_m=rest_m,
                    episode=episode,
                )
                wrong = {
                    name: len(clip.frames(name))
                    for name in clip.cameras
                    if len(clip.frames(name)) != about["frame_count"]
                }
                unsaid = [said for camera in clip.cameras.values() for said in CAMERA if said not in camera]
            except KeyError as error:
                raise BadInput(f"{path}: not a readable appearance ({error}); render the episodes again") from error
            if unsaid:
                raise BadInput(f"{path}: not a readable appearance ({unsaid[0]!r}); render the episodes again")
            if wrong:
                raise BadInput(
                    f"{path.parent}: frames per camera {wrong}, appearance.json says {about['frame_count']}; render again"
                )
            clips.append(clip)
    return clips
