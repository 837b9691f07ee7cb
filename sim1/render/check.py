"""What must hold for an artifact of rendered episodes."""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from sim1.episode import Episode, episode_folders, read_episode
from sim1.render.frame import MAX_MEAN, MIN_MEAN, MIN_SPREAD, is_lit, read_frame
from sim1.render.job import FRAME_NAME
from sim1.render.visible import MIN_CONTRAST, contrast, faces_of
from sim1.stage import BadInput, Finding


@dataclass
class _Faults:
    """What is wrong, for every finding."""

    counts: list[str] = field(default_factory=list)
    sizes: list[str] = field(default_factory=list)
    dark: list[str] = field(default_factory=list)
    hidden: list[str] = field(default_factory=list)
    contrasts: list[float] = field(default_factory=list)  # of all standing cameras
    clip_count: int = 0
    frame_count: int = 0


def check_frames(artifact: Path) -> list[Finding]:
    """Findings `garment_readable`, `clips_present`, `frames_match_states`, `frames_readable`, `frames_lit`, `garment_visible`.

    Whether the garment is seen is not asked where its faces cannot be read: the first finding says so.
    """
    found = _Faults()
    file = artifact / "garment.npz"
    faces = faces_of(file)
    for folder in episode_folders(artifact):
        try:
            episode = read_episode(folder)
        except BadInput as error:
            found.counts.append(str(error))
            continue
        for path in sorted(folder.glob("v*/appearance.json")):
            found.clip_count += 1
            about = json.loads(path.read_text())
            for name in about["cameras"]:
                _check_camera(found, path.parent / name, about, episode, faces)
    lowest = (
        f"lowest contrast {min(found.contrasts):.1f} of 255 grey levels, limit {MIN_CONTRAST:g}"
        if found.contrasts
        else "no standing camera"
    )
    if faces is None:
        lowest = "not looked at"
    lit = f"mean in {MIN_MEAN:g} to {MAX_MEAN:g}, spread at least {MIN_SPREAD:g} of 255 grey levels"
    return [
        Finding(
            name="garment_readable",
            passed=faces is not None,
            detail=f"{file}: cannot be read as arrays with `faces`; run again"
            if faces is None
            else f"{len(faces)} faces",
        ),
        Finding(
            name="clips_present",
            passed=found.clip_count > 0 and found.frame_count > 0,
            detail=f"{found.clip_count} clips, {found.frame_count} frames; expected at least 1 of each",
        ),
        _finding("frames_match_states", found.counts, f"{found.clip_count} clips", "run again"),
        _finding(
            "frames_readable", found.sizes, f"{found.frame_count} frames of the size in appearance.json", "run again"
        ),
        _finding(
            "frames_lit", found.dark, lit, f"wanted: {lit}; change level of that light in data/appearance/rooms.yaml"
        ),
        _finding(
            "garment_visible",
            found.hidden,
            lowest,
            f"at least {MIN_CONTRAST:g} of 255 grey levels are wanted; make fabric and table differ more in data/appearance, or, at 0, "
            "turn the camera to the garment",
        ),
    ]


def _check_camera(
    found: _Faults, folder: Path, about: dict[str, Any], episode: Episode, faces: np.ndarray | None
) -> None:
    """Look at the frames of one camera of a clip, one at a time: all together they can be larger than a memory."""
    camera, place = about["cameras"][folder.name], f"{folder.parents[1].name}/{folder.parent.name}/{folder.name}"
    look = " in ".join(f"{part} {about['appearance'][part]['name']}" for part in ("table", "room"))
    look = f"fabric {about['appearance']['fabric']['name']} on {look}"
    files = sorted(folder.glob("*.png"))
    expected = len(range(0, episode.frame_count, about["stride"]))
    if [file.name for file in files] != [FRAME_NAME.format(index) for index in range(expected)]:
        found.counts.append(f"{place}: {len(files)} frames, {expected} states")
    found.frame_count += len(files)
    for number, file in enumerate(files):
        image = read_frame(file, width=camera["width"], height=camera["height"])
        if image is None:
            found.sizes.append(f"{place}/{file.name} is no picture of {camera['width']} x {camera['height']} px")
            continue
        if not is_lit(image):
            found.dark.append(f"{place}/{file.name}: mean {image.mean():.1f}, spread {image.std():.1f} ({look})")
        if number == 0 and not camera["moves"] and faces is not None:
            found.contrasts.append(contrast(image, episode.garment_m[0], faces, camera))
            if found.contrasts[-1] < MIN_CONTRAST:
                found.hidden.append(f"{place}: {found.contrasts[-1]:.1f} ({look})")


def _finding(name: str, faults: list[str], fine: str, remedy: str) -> Finding:
    detail = f"{len(faults)} at fault: {'; '.join(faults[:3])}; {remedy}" if faults else fine
    return Finding(name=name, passed=not faults, detail=detail)
