"""What holds for this project's own datasets beyond the format: states, actions and pictures are those of the episode named."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

from sim1.dataset.beside import PROVENANCE, read_provenance
from sim1.dataset.check import finding
from sim1.dataset.check_pictures import check_pictures
from sim1.dataset.keypoints import KEYPOINTS
from sim1.dataset.references import COLUMNS, References
from sim1.dataset.tables import INFO, Tables, column, read_tables
from sim1.stage import BadInput, Finding

ROUNDING = 1e-6  # rad, openness or m: what was kept was never rounded


def check_provenance(artifact: Path) -> list[Finding]:
    """Findings `provenance_complete`, `moments_match_states`, `moments_match_pictures`; the first alone where that fails.

    Each episode is held to a few of its moments, kept when it was made: see `sim1.dataset.references`.
    """
    path = artifact / PROVENANCE
    try:
        if not path.is_file():
            raise BadInput(f"{path}: missing; make the dataset again")
        provenance, tables = read_provenance(path), read_tables(artifact / "lerobot")
        if missing := [name for name in COLUMNS if name not in provenance]:
            raise BadInput(f"{PROVENANCE}: no column {', '.join(missing)}; make the dataset again")
        references = read_references(provenance)
    except BadInput as error:
        return [Finding(name="provenance_complete", passed=False, detail=str(error))]
    faults = []
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
    return [
        complete,
        _states(provenance, references, tables),
        check_pictures(artifact / "lerobot", references, tables),
    ]


def read_references(provenance: pd.DataFrame) -> dict[int, References]:
    """What every episode is held to, by its number.

    Raises:
        BadInput: a row is at fault.
    """
    found = {}
    for row in provenance.to_dict("records"):
        try:
            found[int(row["episode_index"])] = References.of_row(row, sorted(json.loads(row["cameras"])))
        except (BadInput, ValueError, TypeError) as error:
            raise BadInput(
                f"{PROVENANCE}: episode {row['episode_index']}: {error}; restore the file, or make the dataset again"
            ) from error
    return found


def _states(provenance: pd.DataFrame, references: dict[int, References], tables: Tables) -> Finding:
    """Length, and states, actions and garment at every moment that was kept."""
    name = "moments_match_states"
    if missing := [key for key in ("observation.state", "action") if key not in tables.info["features"]]:
        return finding(name, [f"{INFO}: features has no {', '.join(missing)}"], "")
    kept = {"observation.state": "states", "action": "actions"}
    if KEYPOINTS in tables.info["features"]:  # a privileged column that may have been removed
        kept[KEYPOINTS] = "keypoints_m"
    columns = {key: column(tables.frames, key) for key in kept}
    faults, count = [], 0
    for row in tables.episodes.itertuples():
        start, end, index = row.dataset_from_index, row.dataset_to_index, row.episode_index
        if not 0 <= start < end <= len(tables.frames):
            faults.append(f"episode {index}: said to be at frames {start}..{end} of {len(tables.frames)}")
            continue
        if (length := int(provenance["frame_count"].iloc[index])) != end - start:
            faults.append(f"episode {index}: {end - start} frames, {PROVENANCE} says {length}")
            continue
        reference = references[index]
        for key, place in kept.items():
            for frame, known in zip(reference.frames, getattr(reference, place), strict=True):
                count += 1
                seen = columns[key][start + frame]
                if known.shape != seen.shape or not np.allclose(seen, known, rtol=0.0, atol=ROUNDING):
                    where = tables.place(int(start + frame))
                    faults.append(f"episode {index}: {key} of {where} is not that of frame {frame} in {PROVENANCE}")
                    break
    return finding(name, faults, f"{count} vectors of {len(provenance)} episodes, {', '.join(kept)}")
