"""Whether the garment is seen in the first frame of a clip: light decides, too, and no rule about colours knows that before."""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from sim1.array_file import read_numbers
from sim1.episode import episode_folders, read_episode
from sim1.render.appearance_file import NAME, read_about
from sim1.render.cameras import project
from sim1.render.frame import read_frame
from sim1.render.job import FRAME_NAME
from sim1.stage import BadInput

MIN_CONTRAST = 8.0  # distance of the garment's mean colour from its surroundings', grey levels
MIN_SHARE = 0.01  # of the picture that the garment covers in the first frame


def hidden_clips(artifact: Path) -> list[tuple[str, int]]:
    """Episode and number of the appearance of clips of which a standing camera does not show the garment in its first frame.

    A garment that is out of the picture is none of them: no other look helps there. Frames that are no pictures are left to the stage's check.

    Raises:
        BadInput: an episode is damaged.
    """
    faces = faces_of(artifact / "garment.npz")
    found = []
    for folder in episode_folders(artifact) if faces is not None else []:
        garment_m = read_episode(folder).garment_m[0]
        for path in sorted(folder.glob(f"v*/{NAME}")):
            about = read_about(path)
            standing = {name: camera for name, camera in about["cameras"].items() if not camera["moves"]}
            seen = [_first_contrast(path.parent / name, garment_m, faces, camera) for name, camera in standing.items()]
            if any(one is not None and 0.0 < one < MIN_CONTRAST for one in seen):
                found.append((folder.name, about["variant"]))
    return found


def _first_contrast(folder: Path, garment_m: np.ndarray, faces: np.ndarray, camera: dict) -> float | None:
    image = read_frame(folder / FRAME_NAME.format(0), width=camera["width"], height=camera["height"])
    return None if image is None else contrast(image, garment_m, faces, camera)


def faces_of(file: Path) -> np.ndarray | None:
    """Faces of the garment (f, 3) in `garment.npz`; None where the file is damaged."""
    try:
        return read_numbers(file, {"faces": ("f", 3)})["faces"]
    except BadInput:
        return None


def contrast(image: np.ndarray, garment_m: np.ndarray, faces: np.ndarray, camera: dict) -> float:
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
