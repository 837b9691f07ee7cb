"""`appearance.json` beside the frames of a clip: what they show, and whether frames that lie there show that."""

import json
import shutil
from pathlib import Path
from typing import Any

from sim1.render.appearance import SCHEMA
from sim1.stage import BadInput
from sim1.whole_file import whole_file

NAME = "appearance.json"
RENDERED_ON = "rendered_on"  # devices; known when frames are rendered, and no reason to render them again


def write_about(folder: Path, about: dict[str, Any]) -> None:
    """Write what is to be rendered into a clip's folder; frames in it are kept where they show just that, else removed.

    Args:
        folder: of the clip.
        about: everything that the frames depend on.
    """
    path = folder / NAME
    about = json.loads(json.dumps(about))  # as it is read back: tuples are lists there
    before = _found(path)
    devices = before.pop(RENDERED_ON, [])
    if before != about:
        shutil.rmtree(folder, ignore_errors=True)
        devices = []
    _write(path, {**about, RENDERED_ON: devices})


def note_device(folder: Path, device: str) -> None:
    """Add a device to those that rendered frames in a clip's folder; nothing where no `appearance.json` tells of them."""
    path = folder / NAME
    if about := _found(path):
        _write(path, {**about, RENDERED_ON: sorted({*about[RENDERED_ON], device})})


def read_about(path: Path) -> dict[str, Any]:
    """An `appearance.json`.

    Raises:
        BadInput: not readable, or of another schema.
    """
    try:
        about = json.loads(path.read_text())
        if about["schema"] != SCHEMA:
            raise ValueError(f"schema is {about['schema']!r}, expected {SCHEMA!r}")
        return about
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{path}: not a readable appearance ({error}); make rendered_episodes again") from error


def _found(path: Path) -> dict[str, Any]:
    """What lies there; nothing where a writing was cut short."""
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError):
        return {}


def _write(path: Path, about: dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as part:
        part.write_text(json.dumps(about, indent=1, sort_keys=True) + "\n")
