"""What must hold for an artifact of rendered episodes."""

import json
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from sim1.episode import episode_folders, read_episode
from sim1.render.cameras import project
from sim1.stage import BadInput, Finding

MIN_MEAN, MAX_MEAN = 6.0, 249.0  # grey levels of 255: neither black nor burnt out
MIN_SPREAD = 4.0  # standard deviation in a frame, grey levels: not one colour
MIN_CONTRAST = 8.0  # distance of the garment's mean colour from its surroundings', grey levels
MIN_SHARE = 0.01  # of the picture that the garment covers in the first frame


def check_frames(artifact: Path) -> list[Finding]:
    """Findings `frames_match_states`, `frames_readable`, `frames_lit`, `garment_visible`."""
    counts, sizes, dark, hidden = [], [], [], []
    frame_count, clip_count, contrasts = 0, 0, []
    faces = _faces(artifact)
    for folder in episode_folders(artifact):
        try:
            episode = read_episode(folder)
        except BadInput as error:
            counts.append(str(error))
            continue
        for path in sorted(folder.glob("v*/appearance.json")):
            clip_count += 1
            about = json.loads(path.read_text())
            expected = len(range(0, episode.frame_count, about["stride"]))
            for name, camera in about["cameras"].items():
                place = f"{folder.name}/{path.parent.name}/{name}"
                files = sorted((path.parent / name).glob("*.png"))
                numbered = [f"{index:06d}.png" for index in range(expected)]
                if [file.name for file in files] != numbered:
                    counts.append(f"{place}: {len(files)} frames, {expected} states")
                frames = {file: _read(file) for file in files}
                frame_count += len(frames)
                sizes += [
                    f"{file}"
                    for file, image in frames.items()
                    if image is None or image.shape != (camera["height"], camera["width"], 3)
                ]
                dark += [
                    f"{place}/{file.name}" for file, image in frames.items() if image is not None and not _lit(image)
                ]
                first = frames[files[0]] if files else None
                if first is not None and not camera["moves"]:
                    contrast = _contrast(first, episode.garment_m[0], faces, camera)
                    contrasts.append(contrast)
                    if contrast < MIN_CONTRAST:
                        hidden.append(f"{place}: {contrast:.1f}")
    lowest = (
        f"lowest contrast {min(contrasts):.1f} of 255, limit {MIN_CONTRAST:g}" if contrasts else "no standing camera"
    )
    return [
        Finding(
            name="clips_present",
            passed=clip_count > 0,
            detail=f"{clip_count} clips, {frame_count} frames; expected at least 1 clip",
        ),
        _finding("frames_match_states", counts, f"{clip_count} clips"),
        _finding("frames_readable", sizes, f"{frame_count} frames of the size in appearance.json"),
        _finding("frames_lit", dark, f"mean in {MIN_MEAN:g}..{MAX_MEAN:g}, spread at least {MIN_SPREAD:g} grey levels"),
        _finding("garment_visible", hidden, lowest),
    ]


def _finding(name: str, faults: list[str], fine: str) -> Finding:
    detail = f"{len(faults)} at fault: {'; '.join(faults[:3])}" if faults else fine
    return Finding(name=name, passed=not faults, detail=detail)


def _read(path: Path) -> np.ndarray | None:
    try:
        with Image.open(path) as image:
            return np.asarray(image.convert("RGB"), float)
    except (OSError, SyntaxError):  # Pillow says the latter of some damaged PNG files
        return None


def _lit(image: np.ndarray) -> bool:
    return MIN_MEAN <= image.mean() <= MAX_MEAN and image.std() >= MIN_SPREAD


def _faces(artifact: Path) -> np.ndarray:
    """Faces of the garment (f, 3); none where the file is damaged, so that no garment is seen."""
    try:
        with np.load(artifact / "garment.npz", allow_pickle=False) as data:
            return data["faces"]
    except (OSError, KeyError, ValueError):
        return np.zeros((0, 3), int)


def _contrast(image: np.ndarray, garment_m: np.ndarray, faces: np.ndarray, camera: dict) -> float:
    """Colour distance between the garment's pixels and a frame around them; 0 where the garment is out of the picture."""
    height, width = camera["height"], camera["width"]
    pixels, depth_m = project(
        garment_m,
        camera_to_world=np.array(camera["camera_to_world"]),
        fy_over_height=camera["fy_px"] / height,
        width=width,
        height=height,
    )
    canvas = Image.new("1", (width, height))
    draw = ImageDraw.Draw(canvas)
    for face in faces[(depth_m[faces] > 0).all(axis=1)]:
        draw.polygon([tuple(pixel) for pixel in pixels[face].tolist()], fill=1)
    mask = np.asarray(canvas)
    if mask.mean() < MIN_SHARE:
        return 0.0
    rows, columns = np.nonzero(mask)
    margin = max(2, round(0.08 * height))
    top, left = max(rows.min() - margin, 0), max(columns.min() - margin, 0)
    around = np.zeros_like(mask)
    around[top : rows.max() + margin + 1, left : columns.max() + margin + 1] = True
    around[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1] = False
    if not around.any():
        return 0.0
    return float(np.linalg.norm(image[mask].mean(axis=0) - image[around].mean(axis=0)))
