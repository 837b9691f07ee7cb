"""Videos of a LeRobot v3 dataset: decodable to the end, and as long as the episodes that lie in them."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import av
import numpy as np
import pandas as pd

from sim1.dataset.tables import INFO, REMEDY, TIME_TOLERANCE_S, Tables
from sim1.stage import Finding


def check_videos(root: Path, tables: Tables) -> Finding:
    """Finding `videos_complete`: every frame of every episode is in its file, at the time where LeRobot's reader asks for it."""
    from sim1.dataset.check import finding

    keys = [name for name, feature in tables.info["features"].items() if feature["dtype"] == "video"]
    faults, count = [], 0
    for key in keys:
        for path, episodes in video_files(root, tables, key):
            try:
                times_s, sizes = _decode(path)
            except (OSError, ValueError, av.error.FFmpegError) as error:
                said = "missing" if isinstance(error, FileNotFoundError) else f"cannot be decoded ({error})"
                faults.append(f"{path.relative_to(root)}: {said}; {REMEDY}")
                continue
            count += len(times_s)
            faults += _faults(path.relative_to(root), times_s, sizes, episodes, key, tables)
    return finding("videos_complete", faults, f"{count} frames of {len(keys)} cameras decoded")


def video_files(root: Path, tables: Tables, key: str) -> Iterator[tuple[Path, pd.DataFrame]]:
    """Every video file of a camera and the episodes in it, by time."""
    chunk, file = f"videos/{key}/chunk_index", f"videos/{key}/file_index"
    for (chunk_index, file_index), episodes in tables.episodes.groupby([chunk, file]):
        path = root / tables.info["video_path"].format(video_key=key, chunk_index=chunk_index, file_index=file_index)
        yield path, episodes.sort_values(f"videos/{key}/from_timestamp")


def frame_at(path: Path, time_s: float) -> np.ndarray:
    """The frame (h, w, 3) u8 nearest to a time, decoding from the keyframe before it."""
    with _opened(path) as (container, stream):
        container.seek(max(round(time_s / stream.time_base) - 1, 0), stream=stream, backward=True)
        best, distance = None, np.inf
        for frame in container.decode(stream):
            off = abs(float(frame.pts * stream.time_base) - time_s)
            if off >= distance:
                break
            best, distance = frame, off
        if best is None:
            raise ValueError(f"no frame at {time_s:.3f} s")
        return best.to_ndarray(format="rgb24")


@contextmanager
def _opened(path: Path) -> Iterator[tuple[av.container.InputContainer, av.VideoStream]]:
    """A video file and its stream.

    Raises:
        OSError, ValueError, av.error.FFmpegError: it is missing, damaged, or holds no video that can be decoded.
    """
    with av.open(str(path)) as container:
        if not container.streams.video:
            raise ValueError("no video in it")
        stream = container.streams.video[0]
        if stream.codec_context is None:  # PyAV ends the process where such a stream is decoded
            raise ValueError("its video is of no known codec")
        yield container, stream


def _decode(path: Path) -> tuple[np.ndarray, set[tuple[int, int]]]:
    """Time of every frame [s] and the sizes (height, width) that occur."""
    times, sizes = [], set()
    with _opened(path) as (container, stream):
        for frame in container.decode(stream):
            if frame.pts is None:
                raise ValueError(f"frame {len(times)} has no time")
            times.append(float(frame.pts * stream.time_base))
            sizes.add((frame.height, frame.width))
    return np.array(times), sizes


def _faults(
    name: Path, times_s: np.ndarray, sizes: set, episodes: pd.DataFrame, key: str, tables: Tables
) -> Iterator[str]:
    fps, feature = tables.info["fps"], tables.info["features"][key]
    if len(times_s) != episodes["length"].sum():
        yield f"{name}: {len(times_s)} frames, its episodes have {episodes['length'].sum()}"
        return
    height, width = size_of(feature)
    if sizes != {(height, width)}:
        yield f"{name}: size {sorted(sizes)}, {INFO} says {(height, width)}"
    off = np.abs(times_s - times_s[0] - np.arange(len(times_s)) / fps)
    if off.max() >= TIME_TOLERANCE_S:
        frame = int(off.argmax())
        yield f"{name}: frame {frame} is at {times_s[frame]:.4f} s, {off[frame]:.2g} s off {fps:g} a second"
        return
    start, stamps_s = 0, tables.frames["timestamp"].to_numpy()
    for index, length, first, begin, end in episodes[
        ["episode_index", "length", "dataset_from_index", f"videos/{key}/from_timestamp", f"videos/{key}/to_timestamp"]
    ].itertuples(index=False):
        where = f"{name}: episode {index}: "
        own_s = stamps_s[first : first + length].astype(float)
        if len(own_s) < length:  # the table is at fault, and said to be
            own_s = np.arange(length) / fps
        yield from (where + fault for fault in _apart(begin, end, own_s, times_s[start : start + length], 1.0 / fps))
        start += length


def _apart(begin_s: float, end_s: float, own_s: np.ndarray, times_s: np.ndarray, step_s: float) -> Iterator[str]:
    """What LeRobot's reader, which asks for `begin_s + own_s` and compares in float32, refuses or takes for another frame.

    Its tools cut an episode out of the file from `begin_s` to `end_s`.
    """
    off_s = np.abs((begin_s + own_s).astype(np.float32) - times_s.astype(np.float32))
    if (wrong := np.flatnonzero(~(off_s < TIME_TOLERANCE_S))).size:
        frame = wrong[0]
        yield (
            f"from_timestamp is {begin_s:.4f} s: frame {frame} is asked for at {begin_s + own_s[frame]:.4f} s and lies at "
            f"{times_s[frame]:.4f} s, LeRobot allows {TIME_TOLERANCE_S:g} s"
        )
    if not abs(end_s - times_s[-1] - step_s) < TIME_TOLERANCE_S:
        yield f"to_timestamp is {end_s:.4f} s, its last frame ends at {times_s[-1] + step_s:.4f} s"


def size_of(feature: dict[str, Any]) -> tuple[int, int]:
    """Height and width: LeRobot knows channels before and after them, by the names."""
    names, shape = feature.get("names"), feature["shape"]
    first = isinstance(names, list) and str(names[0]).startswith("channel")
    return tuple(shape[1:] if first else shape[:2])
