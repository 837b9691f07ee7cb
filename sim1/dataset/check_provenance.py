"""What holds for this project's own datasets beyond the format: pictures and states belong together."""

from pathlib import Path

import av
import numpy as np
import pandas as pd

from sim1.dataset.check import finding
from sim1.dataset.check_videos import frame_at, video_files
from sim1.dataset.tables import Tables, column, read_tables
from sim1.dataset.write import thumbnail
from sim1.stage import Finding

MAX_THUMBNAIL_ERROR = 12.0  # mean grey levels of 255 that the codec may change


def check_provenance(artifact: Path) -> list[Finding]:
    """Findings `provenance_complete`, `ends_match_states`, `ends_match_pictures`; the first alone where that fails."""
    try:
        provenance = pd.read_parquet(artifact / "provenance.parquet")
        tables = read_tables(artifact / "lerobot")
    except (OSError, KeyError, ValueError) as error:
        return [Finding(name="provenance_complete", passed=False, detail=str(error))]
    rows = provenance["episode_index"].tolist() == tables.episodes["episode_index"].tolist()
    unique = not provenance.duplicated(["garment", "trajectory", "appearance"]).any()
    complete = Finding(
        name="provenance_complete",
        passed=bool(rows and unique),
        detail=f"{len(provenance)} rows for {len(tables.episodes)} episodes, {'none' if unique else 'some'} twice",
    )
    if not complete.passed:
        return [complete]
    return [complete, _states(provenance, tables), _pictures(artifact / "lerobot", provenance, tables)]


def _states(provenance: pd.DataFrame, tables: Tables) -> Finding:
    """First and last state of every episode are those of the trajectory that it was made from."""
    states = column(tables.frames, "observation.state")
    faults = []
    for row, start, end in zip(
        provenance.itertuples(), tables.episodes["dataset_from_index"], tables.episodes["dataset_to_index"]
    ):
        said = np.array([row.first_state, row.last_state])
        inside = 0 <= start < end <= len(states)
        if not inside or not np.allclose(states[[start, end - 1]], said, atol=1e-6):
            faults.append(f"episode {row.episode_index}")
    return finding("ends_match_states", faults, f"{len(provenance)} episodes")


def _pictures(root: Path, provenance: pd.DataFrame, tables: Tables) -> Finding:
    """First and last frame of every episode are those that were rendered for those states."""
    key = min(name for name, feature in tables.info["features"].items() if feature["dtype"] == "video")
    thumbnails = provenance.set_index("episode_index")
    faults, worst = [], 0.0
    for path, episodes in video_files(root, tables, key):
        for index, begin, end in episodes[
            ["episode_index", f"videos/{key}/from_timestamp", f"videos/{key}/to_timestamp"]
        ].itertuples(index=False):
            for which, time_s in (("first", begin), ("last", end - 1.0 / tables.info["fps"])):
                try:
                    seen = np.array(thumbnail(frame_at(path, time_s)), float)
                except (OSError, ValueError, av.error.FFmpegError) as error:
                    faults.append(f"episode {index}, {which} frame: {error}")
                    continue
                error = float(np.abs(seen - thumbnails.loc[index, f"{which}_thumbnail"]).mean())
                worst = max(worst, error)
                if error > MAX_THUMBNAIL_ERROR:
                    faults.append(f"episode {index}, {which} frame: {error:.1f} grey levels off")
    return finding("ends_match_pictures", faults, f"worst {worst:.1f} grey levels off, limit {MAX_THUMBNAIL_ERROR:g}")
