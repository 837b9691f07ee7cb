"""What holds for this project's own datasets beyond the format: pictures and states belong together."""

from pathlib import Path

import av
import numpy as np
import pandas as pd

from sim1.dataset.beside import PROVENANCE, read_provenance
from sim1.dataset.check import finding
from sim1.dataset.check_videos import frame_at, video_files
from sim1.dataset.tables import INFO, Tables, column, read_tables
from sim1.dataset.write import thumbnail
from sim1.stage import BadInput, Finding

ENDS = ("first_state", "last_state", "first_thumbnail", "last_thumbnail")
MAX_THUMBNAIL_ERROR = 12.0  # mean grey levels of 255 that the codec may change


def check_provenance(artifact: Path) -> list[Finding]:
    """Findings `provenance_complete`, `ends_match_states`, `ends_match_pictures`; the first alone where that fails."""
    path = artifact / PROVENANCE
    try:
        if not path.is_file():
            raise BadInput(f"{path}: missing; make the dataset again")
        provenance, tables = read_provenance(path), read_tables(artifact / "lerobot")
    except BadInput as error:
        return [Finding(name="provenance_complete", passed=False, detail=str(error))]
    faults = [f"{PROVENANCE}: no column {name}" for name in ENDS if name not in provenance]
    known, there = provenance["episode_index"].tolist(), tables.episodes["episode_index"].tolist()
    if known != there:
        faults.append(f"{PROVENANCE}: rows of episodes {known!s:.60}, the dataset has {there!s:.60}")
    if len(twice := np.flatnonzero(provenance.duplicated(["garment", "trajectory", "appearance"]))):
        row = provenance.iloc[twice[0]]
        said = f"{row.garment}, {row.trajectory}, {row.appearance}"
        faults.append(f"{PROVENANCE}: episode {row.episode_index} has the origin of an episode before ({said})")
    if faults:
        return [finding("provenance_complete", faults, "")]
    complete = finding("provenance_complete", [], f"{len(provenance)} rows for {len(there)} episodes, none twice")
    return [complete, _states(provenance, tables), _pictures(artifact / "lerobot", provenance, tables)]


def _states(provenance: pd.DataFrame, tables: Tables) -> Finding:
    """First and last state of every episode are those of the trajectory that it was made from."""
    if "observation.state" not in tables.info["features"]:
        return finding("ends_match_states", [f"{INFO}: features has no observation.state"], "")
    states = column(tables.frames, "observation.state")
    faults = []
    for row, start, end in zip(
        provenance.itertuples(), tables.episodes["dataset_from_index"], tables.episodes["dataset_to_index"]
    ):
        if not 0 <= start < end <= len(states):
            faults.append(f"episode {row.episode_index}: said to be at frames {start}..{end} of {len(states)}")
            continue
        for which, frame, said in (("first", start, row.first_state), ("last", end - 1, row.last_state)):
            known = np.array(said, float)
            if known.shape != states[frame].shape or not np.allclose(states[frame], known, atol=1e-6):
                faults.append(
                    f"episode {row.episode_index}: {tables.place(frame)} is not the {which} state in {PROVENANCE}"
                )
    return finding("ends_match_states", faults, f"{len(provenance)} episodes")


def _pictures(root: Path, provenance: pd.DataFrame, tables: Tables) -> Finding:
    """First and last frame of every episode are those that were rendered for those states."""
    keys = [name for name, feature in tables.info["features"].items() if feature["dtype"] == "video"]
    if not keys:
        return finding("ends_match_pictures", [f"{INFO}: features has no video"], "")
    key = min(keys)
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
                known = np.array(thumbnails.loc[index, f"{which}_thumbnail"], float)
                if known.shape != seen.shape:
                    faults.append(f"episode {index}: {which}_thumbnail in {PROVENANCE} has {known.size} values")
                    continue
                error = float(np.abs(seen - known).mean())
                worst = max(worst, error)
                if error > MAX_THUMBNAIL_ERROR:
                    faults.append(f"episode {index}, {which} frame: {error:.1f} grey levels off")
    return finding("ends_match_pictures", faults, f"worst {worst:.1f} grey levels off, limit {MAX_THUMBNAIL_ERROR:g}")
