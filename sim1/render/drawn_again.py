"""Appearances that hid the garment, noted while others are rendered in their place: a killed run goes on with these.

The note holds for the same work alone: of other looks, motions or settings nobody knows yet which hide the garment. It
is no part of the artifact.
"""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from sim1.episode import episode_folders
from sim1.render.stage import RenderConfig
from sim1.stage import Inputs, only

FILE = "drawn_again.json"
NO_MATTER = ("workers", "threads")  # settings that change no picture

type Hidden = list[tuple[str, int]]
"""Trajectory and number of the appearance, of all clips that hid the garment at once."""


def work_of(inputs: Inputs, garment: str, config: RenderConfig) -> str:
    """Digest of all that decides which appearances are drawn and whether they show the garment."""
    settings = {key: value for key, value in asdict(config).items() if key not in NO_MATTER}
    content = hashlib.sha256(json.dumps([garment, settings], sort_keys=True).encode())
    folders = [only(inputs, name) for name in ("appearance", "garment_mesh", "scene")]
    files = [path for folder in folders for path in sorted(folder.rglob("*")) if path.is_file()]
    files += [folder / "episode.npz" for folder in episode_folders(only(inputs, "valid_trajectories"))]
    for path in files:
        with path.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
        content.update(f"{path.parent.name}/{path.name} {digest} ".encode())
    return content.hexdigest()


def read_hidden(out: Path, work: str) -> list[Hidden]:
    """What was noted of that work, draw by draw; nothing where nobody noted it."""
    try:
        note = json.loads((out / FILE).read_text())
        draws = [[(str(episode), int(variant)) for episode, variant in hidden] for hidden in note["draws"]]
        return draws if note["work"] == work else []
    except (OSError, ValueError, KeyError, TypeError):
        return []


def note_hidden(out: Path, work: str, draws: Sequence[Hidden]) -> None:
    """Note it, whole or not at all."""
    part = out / f"{FILE}.part"
    part.write_text(json.dumps({"work": work, "draws": draws}) + "\n")
    part.replace(out / FILE)


def forget_hidden(out: Path) -> None:
    """Leave nothing of the note."""
    for name in (FILE, f"{FILE}.part"):
        (out / name).unlink(missing_ok=True)
