"""Whether the pictures of an episode, from every camera, are those that were rendered for its states.

First and last frame of an episode may differ by less than two of a codec's worst frames: a folded towel on a table, the arms at
home. What differs is in one place, though, and a codec's errors are all over the picture. So it is asked how far a picture lies
on the way from the moment it should show towards another moment of any episode: the codec's errors move it little in any one
direction.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np

from sim1.dataset.check import finding
from sim1.dataset.check_videos import frame_at, video_files
from sim1.dataset.references import References, thumbnail
from sim1.dataset.tables import INFO, Tables
from sim1.stage import Finding

CAMERA = "observation.images."
MAX_ERROR = 12.0  # mean grey levels of 255 that a codec may change
# Share of the way towards another moment: 0 is the moment itself, 1 the other. Of 50 moments of ten episodes (96 x 72) the worst came
# to 0.04 as the dataset is written (h264, 23), to 0.21 at 45, and to 0.39 at the worst that each codec can do (51, AV1 at 63).
MAX_WAY = 0.5
MIN_APART = 3.0  # rms grey levels of 255 by which two moments differ; below, codecs make them one
BLOCK = 2000  # pictures that are compared with each other; all with all would take hours with 100,000 episodes


@dataclass(frozen=True, kw_only=True)
class _Picture:
    episode: int
    frame: int
    seen: np.ndarray
    known: np.ndarray


def check_pictures(root: Path, references: dict[int, References], tables: Tables) -> Finding:
    """Finding `moments_match_pictures`: each kept moment is shown, and no other one of the same episode or of one near it.

    Args:
        root: of the LeRobot dataset.
        references: by episode.
        tables: of the dataset.
    """
    name = "moments_match_pictures"
    keys = sorted(key for key, feature in tables.info["features"].items() if feature["dtype"] == "video")
    if not keys:
        return finding(name, [f"{INFO}: features has no video"], "")
    faults, error, way, count = [], 0.0, 0.0, 0
    for key in keys:
        pictures: list[_Picture] = []
        faults += _read(root, tables, key, references, pictures)
        count += len(pictures)
        for start in range(0, len(pictures), BLOCK):
            block = pictures[start : start + BLOCK]
            errors, ways, others = _compared(block)
            error, way = max(error, errors.max()), max(way, ways.max())
            faults += _faults(key.removeprefix(CAMERA), block, errors, ways, others)
    fine = (
        f"{count} pictures of {len(keys)} cameras, at worst {error:.1f} grey levels off, limit {MAX_ERROR:g}, and {way:.2f} of the "
        f"way to another moment, limit {MAX_WAY:g}"
    )
    return finding(name, faults, fine)


def _read(
    root: Path, tables: Tables, key: str, references: dict[int, References], pictures: list[_Picture]
) -> Iterator[str]:
    """Decode a camera's kept moments into `pictures`; yields what cannot be."""
    camera = key.removeprefix(CAMERA)
    for path, episodes in video_files(root, tables, key):
        for index, begin_s in episodes[["episode_index", f"videos/{key}/from_timestamp"]].itertuples(index=False):
            reference = references[index]
            if camera not in reference.thumbnails:
                yield f"episode {index}: provenance knows no camera {camera}"
                continue
            for frame, known in zip(reference.frames, reference.thumbnails[camera], strict=True):
                try:
                    seen = np.array(thumbnail(frame_at(path, begin_s + frame / tables.info["fps"])), float)
                except (OSError, ValueError, av.error.FFmpegError) as error:
                    yield f"episode {index}, frame {frame} of {camera}: {error}"
                    continue
                if known.shape != seen.shape:
                    yield f"episode {index}: reference_thumbnails of {camera} have {known.size} values, not {seen.size}"
                    break
                pictures.append(_Picture(episode=int(index), frame=int(frame), seen=seen, known=known))


def _compared(pictures: list[_Picture]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each picture: mean error, the longest way towards another moment, and which moment that is, (n,) each."""
    seen, known = (np.stack([getattr(one, name) for one in pictures]) for name in ("seen", "known"))
    errors = np.abs(seen - known).mean(axis=1)
    # (seen - known) . (other - known) / |other - known|², for all others at once, in mean squares.
    shift = seen - known
    dot = (shift @ known.T - (shift * known).sum(axis=1)[:, None]) / known.shape[1]
    square = (known**2).mean(axis=1)
    apart = np.maximum(square[:, None] + square - 2.0 * (known @ known.T) / known.shape[1], 0.0)
    ways = np.where(apart >= MIN_APART**2, dot / np.maximum(apart, MIN_APART**2), -np.inf)
    others = ways.argmax(axis=1)
    return errors, np.maximum(ways.max(axis=1), 0.0), others


def _faults(
    camera: str, pictures: list[_Picture], errors: np.ndarray, ways: np.ndarray, others: np.ndarray
) -> Iterator[str]:
    for one, error, way, other in zip(pictures, errors, ways, others, strict=True):
        where = f"episode {one.episode}, frame {one.frame} of {camera}"
        if error > MAX_ERROR:
            yield f"{where}: {error:.1f} grey levels off, limit {MAX_ERROR:g}"
        elif way > MAX_WAY:
            shown = pictures[other]
            yield (
                f"{where}: {way:.2f} of the way to frame {shown.frame} of episode {shown.episode}, limit {MAX_WAY:g}"
            )
