"""A dataset held to the simulation's own files, frame by frame, where they are at hand."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from sim1.dataset.beside import KEYPOINTS as KEYPOINTS_FILE
from sim1.dataset.beside import PROVENANCE, Beside
from sim1.dataset.check import finding
from sim1.dataset.keypoints import KEYPOINTS
from sim1.dataset.references import digest
from sim1.dataset.tables import INFO, Tables, column, read_tables
from sim1.episode import ARMS, RATE_HZ, Episode, read_episode
from sim1.stage import BadInput, Finding

NAME = "frames_match_source"
# An artifact, its episodes by garment, or a store with stages above that.
DEPTHS = ("episodes/*/episode.npz", "*/episodes/*/episode.npz", "*/*/episodes/*/episode.npz")
ROUNDING = 1e-6


def sources_beside(artifact: Path) -> list[Path]:
    """Folders that may hold what a dataset was made of: of the store that it lies in, or of `sim1 dataset make`."""
    place = artifact.resolve()
    near = [place.parent / "rendered", *(above / "rendered_episodes" for above in place.parents[1:5])]
    return [folder for folder in near if folder.is_dir()]


def check_source(artifact: Path, folders: Sequence[Path], *, all_there: bool) -> Finding:
    """Finding `frames_match_source`: every state, action and garment keypoint is that of the episode which provenance names.

    An episode's file is found by its digest, whatever it is called: those of a merged dataset have other names there.

    Args:
        artifact: with `lerobot/`, `provenance.parquet` and `keypoints.json`.
        folders: with `episodes/NNNN/episode.npz` in them or at most two folders below.
        all_there: an episode whose file is not found is a fault; otherwise it is left out and counted.
    """
    try:
        tables = read_tables(artifact / "lerobot")
        beside = Beside.of(artifact, episode_count=len(tables.episodes))
        if beside.provenance is None or "episode_sha256" not in beside.provenance:
            raise BadInput(f"{artifact / PROVENANCE}: no column episode_sha256; make the dataset again")
        known = beside.provenance
        files = _files(folders, set(known["episode_sha256"]))
        faults, compared = [], 0
        for row in known.itertuples():
            path = files.get(row.episode_sha256)
            if path is None:
                if all_there:
                    faults.append(
                        f"episode {row.episode_index}: no episode.npz in {', '.join(map(str, folders))} is the one that it was made "
                        f"from ({row.garment}, {row.trajectory}); name the folder of stage rendered_episodes then, or make the dataset again"
                    )
                continue
            compared += 1
            vertices = (beside.keypoints or {}).get(row.garment)
            if vertices is None and KEYPOINTS in tables.info["features"]:
                raise BadInput(f"{artifact / KEYPOINTS_FILE}: no {row.garment}; make the dataset again")
            if fault := _fault(tables, row.episode_index, read_episode(path.parent), vertices):
                faults.append(f"episode {row.episode_index}: {fault} of {path}")
    except BadInput as error:
        return Finding(name=NAME, passed=False, detail=str(error))
    left = len(known) - compared
    return finding(NAME, faults, f"{compared} episodes" + (f"; {left} whose files were not found" if left else ""))


def _files(folders: Iterable[Path], wanted: set[str]) -> dict[str, Path]:
    """Files by digest, of those wanted."""
    found: dict[str, Path] = {}
    for folder in folders:
        for path in (path for depth in DEPTHS for path in sorted(folder.glob(depth))):
            if wanted <= found.keys():
                return found
            if (said := digest(path)) in wanted:
                found.setdefault(said, path)
    return found


def _fault(tables: Tables, index: int, episode: Episode, vertices: list[int] | None) -> str | None:
    """In what an episode of the dataset differs from its source."""
    ratio = RATE_HZ / tables.info["fps"]
    stride = round(ratio)
    if stride < 1 or not np.isclose(stride, ratio):
        return f"{INFO}: fps is {tables.info['fps']:g}, of {RATE_HZ:g} states a second"
    rows = np.flatnonzero(tables.frames["episode_index"] == index)
    at = np.arange(0, episode.frame_count, stride)
    if len(rows) != len(at):
        return f"{len(rows)} frames, expected {len(at)}: every {stride} of the {episode.frame_count}"
    frames = tables.frames.iloc[rows]
    last_before_next = np.minimum(at + stride - 1, episode.frame_count - 1)
    commands = (episode.command_joints_rad, episode.command_openness)
    for name, joints_rad, openness, moment in (
        ("observation.state", episode.joints_rad, episode.openness, at),
        ("action", *commands, last_before_next),
    ):
        feature = tables.info["features"].get(name)
        if feature is None:
            return f"{INFO}: features has no {name}, to compare with that"
        try:
            expected = [_signal(one, joints_rad, openness)[moment] for one in feature["names"]]
        except (ValueError, IndexError, TypeError, KeyError):
            return f"{INFO}: features.{name}.names {feature.get('names')!s:.80} are not those"
        if said := _differs(tables, rows, name, column(frames, name), np.stack(expected, axis=1), at):
            return said
    if vertices is not None and KEYPOINTS in tables.info["features"]:
        if max(vertices) >= episode.garment_m.shape[1]:
            return f"{KEYPOINTS_FILE} names vertex {max(vertices)}, none of the {episode.garment_m.shape[1]}"
        expected = episode.garment_m[at][:, vertices].reshape(len(at), -1)
        return _differs(tables, rows, KEYPOINTS, column(frames, KEYPOINTS), expected, at)
    return None


def _signal(name: str, joints_rad: np.ndarray, openness: np.ndarray) -> np.ndarray:
    """The series (T,) of one number of a state, by its name: `left_joint_3_rad`, `right_openness`."""
    arm, what = name.split("_", 1)
    if what == "openness":
        return openness[:, ARMS.index(arm)]
    joint, number, unit = what.split("_")
    if (joint, unit) != ("joint", "rad"):
        raise ValueError(name)
    return joints_rad[:, ARMS.index(arm), int(number) - 1]


def _differs(
    tables: Tables, rows: np.ndarray, name: str, found: np.ndarray, expected: np.ndarray, at: np.ndarray
) -> str | None:
    if found.shape != expected.shape:
        return f"{name} has shape {found.shape}, expected {expected.shape}"
    off = np.abs(found - expected).max(axis=1)
    if not (wrong := np.flatnonzero(~(off <= ROUNDING))).size:
        return None
    return f"{name} of {tables.place(int(rows[wrong[0]]))} is {off[wrong[0]]:.2g} off frame {at[wrong[0]]}"
