"""Videos of a LeRobot v3 dataset: decodable to the end, and as long as the episodes that lie in them."""

from collections.abc import Iterator
from pathlib import Path

import av
import numpy as np
import pandas as pd

from sim1.dataset.tables import Tables
from sim1.stage import Finding


def check_videos(root: Path, tables: Tables) -> Finding:
    """Finding `videos_complete`: every frame of every episode is in its file, at its time."""
    from sim1.dataset.check import finding

    keys = [name for name, feature in tables.info["features"].items() if feature["dtype"] == "video"]
    faults, count = [], 0
    for key in keys:
        for path, episodes in video_files(root, tables, key):
            try:
                times_s, sizes = _decode(path)
            except (OSError, ValueError, av.error.FFmpegError) as error:
                faults.append(f"{path.relative_to(root)}: {error}")
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
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
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


def _decode(path: Path) -> tuple[np.ndarray, set[tuple[int, int]]]:
    """Time of every frame [s] and the sizes (height, width) that occur."""
    times, sizes = [], set()
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        for frame in container.decode(stream):
            times.append(float(frame.pts * stream.time_base))
            sizes.add((frame.height, frame.width))
    return np.array(times), sizes


def _faults(name: Path, times_s: np.ndarray, sizes: set, episodes: pd.DataFrame, key: str, tables: Tables) -> list[str]:
    fps, faults = tables.info["fps"], []
    if len(times_s) != episodes["length"].sum():
        return [f"{name}: {len(times_s)} frames, its episodes have {episodes['length'].sum()}"]
    if not np.allclose(times_s, np.arange(len(times_s)) / fps, atol=0.25 / fps):
        faults.append(f"{name}: frames are not {fps} a second")
    height, width, _ = tables.info["features"][key]["shape"]
    if sizes != {(height, width)}:
        faults.append(f"{name}: size {sorted(sizes)}, info.json says {(height, width)}")
    start = 0
    for index, length, begin, end in episodes[
        ["episode_index", "length", f"videos/{key}/from_timestamp", f"videos/{key}/to_timestamp"]
    ].itertuples(index=False):
        if max(abs(begin - start / fps), abs(end - (start + length) / fps)) > 0.5 / fps:
            faults.append(
                f"{name}: episode {index} said to be at {begin:.3f}..{end:.3f} s, its frames start at {start / fps:.3f} s"
            )
        start += length
    return faults
