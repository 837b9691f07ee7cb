"""Datasets put together and taken apart, by LeRobot's own tools, with what this project writes beside them."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from sim1.dataset.beside import Beside, joined
from sim1.dataset.check import check_lerobot
from sim1.dataset.quiet import quiet_libraries
from sim1.stage import BadInput, random_stream

NAME = "sim1/local"  # LeRobot wants an owner and a name; nothing is looked up under it


def lerobot_root(folder: Path) -> Path:
    """The LeRobot dataset in a folder: `lerobot/` of an artifact of this project, or the folder itself.

    Raises:
        BadInput: neither is one.
    """
    for root in (folder / "lerobot", folder):
        if (root / "meta" / "info.json").is_file():
            return root
    raise BadInput(f"{folder}: no LeRobot dataset (meta/info.json is missing, also under lerobot/); give its folder")


def merge(folders: Sequence[Path], out: Path) -> int:
    """Write the datasets one after the other as `out/lerobot`, with what lies beside all of them. Returns the episode count.

    Raises:
        BadInput: a folder holds no sound dataset, they do not fit together, or `out` exists.
    """
    from lerobot.datasets.dataset_tools import merge_datasets

    roots = [_sound(folder) for folder in folders]
    kinds = {folder: _kind(root) for folder, root in zip(folders, roots, strict=True)}
    first = kinds[folders[0]]
    for folder, kind in kinds.items():
        if differs := [key for key in sorted({*first, *kind}) if kind.get(key) != first.get(key)]:
            raise BadInput(f"{folder}: {', '.join(differs)}: not as in {folders[0]}; only like is merged with like")
    beside = joined([Beside.of(folder) for folder in folders])
    part = _begin(out)
    with quiet_libraries():
        whole = merge_datasets([_open(root) for root in roots], NAME, output_dir=part / "lerobot")
    beside.write(part)
    return _finish(part, out, whole.meta.total_episodes)


def split(folder: Path, shares: Mapping[str, float], out: Path, seed: int) -> dict[str, int]:
    """Write parts `out/PART/lerobot` that together are the dataset. Returns the episode count of each.

    Episodes that share a source demonstration stay together, where provenance knows them: a policy is never tested on
    motion that it was trained on.

    Raises:
        BadInput: no sound dataset, shares that do not add up to 1, or too few independent episodes for so many parts.
    """
    from lerobot.datasets.dataset_tools import split_dataset

    if not math.isclose(sum(shares.values()), 1.0, abs_tol=1e-6) or min(shares.values()) <= 0:
        raise BadInput(f"--share: {dict(shares)} add up to {sum(shares.values()):g}, expected positive shares of 1")
    root, beside = _sound(folder), Beside.of(folder)
    count = json.loads((root / "meta" / "info.json").read_text())["total_episodes"]
    groups = np.arange(count) if beside.provenance is None else kindred(_sources(beside.provenance))
    parts = shared_out(groups, shares, seed)
    if empty := [name for name, episodes in parts.items() if not episodes]:
        raise BadInput(
            f"{folder}: {len(set(groups.tolist()))} groups of episodes without a common source cannot fill the parts "
            f"{list(shares)}: {', '.join(empty)} would be empty; make episodes from more demonstrations"
        )
    part = _begin(out)
    with quiet_libraries():
        split_dataset(_open(root), parts, output_dir=part / "made")
    for name, episodes in parts.items():
        (part / name).mkdir()
        (part / "made" / name).rename(part / name / "lerobot")
        beside.of_episodes(episodes).write(part / name)
    shutil.rmtree(part / "made")
    _finish(part, out, count)
    return {name: len(episodes) for name, episodes in parts.items()}


def _sources(table: pd.DataFrame) -> list[list[str]]:
    """Source demonstrations of each episode; every garment numbers its own."""
    return [[f"{row.garment}/{name}" for name in row.sources] for row in table.itertuples(index=False)]


def kindred(sources: Sequence[Sequence[str]]) -> np.ndarray:
    """Group number (n,) of each episode: two with a source in common are in one group, and what is linked through others."""
    names = sorted({name for one in sources for name in one})
    pairs = [(row, names.index(name)) for row, one in enumerate(sources) for name in one]
    rows, columns = np.array(pairs, int).reshape(-1, 2).T
    count = len(sources) + len(names)
    links = coo_matrix((np.ones(len(rows)), (rows, len(sources) + columns)), shape=(count, count))
    return connected_components(links, directed=False)[1][: len(sources)]


def shared_out(groups: np.ndarray, shares: Mapping[str, float], seed: int) -> dict[str, list[int]]:
    """Episodes of each part: whole groups, the largest first, in random order among equals, to the part that lacks most."""
    names, sizes = np.unique(groups, return_counts=True)
    order = random_stream(seed, "dataset split").permutation(len(names))
    order = order[np.argsort(-sizes[order], kind="stable")]
    parts: dict[str, list[int]] = {name: [] for name in shares}
    for index in order:
        lacks = {name: share * len(groups) - len(parts[name]) for name, share in shares.items()}
        parts[max(lacks, key=lambda name: lacks[name])] += np.flatnonzero(groups == names[index]).tolist()
    return {name: sorted(episodes) for name, episodes in parts.items()}


def _sound(folder: Path) -> Path:
    root = lerobot_root(folder)
    if failed := [finding for finding in check_lerobot(root) if not finding.passed]:
        raise BadInput(f"{folder}: {failed[0].name}: {failed[0].detail}; `sim1 dataset check` lists all faults")
    return root


def _kind(root: Path) -> dict[str, object]:
    """What must be the same in datasets that are merged."""
    info = json.loads((root / "meta" / "info.json").read_text())
    features = {name: (one["dtype"], tuple(one["shape"])) for name, one in info["features"].items()}
    return {
        "fps": info["fps"],
        "robot_type": info["robot_type"],
        **{f"feature {name}": features[name] for name in features},
    }


def _open(root: Path):
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    return LeRobotDataset(NAME, root=root, video_backend="pyav")


def _begin(out: Path) -> Path:
    if out.exists():
        raise BadInput(f"{out}: exists; give another folder")
    part = out.with_name(f"{out.name}.part")
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir(parents=True)
    return part


def _finish(part: Path, out: Path, count: int) -> int:
    """Check every dataset in `part` and put it in place."""
    for info in sorted(part.rglob("meta/info.json")):
        for finding in check_lerobot(info.parents[1]):
            if not finding.passed:
                raise RuntimeError(f"{part}: {finding.name}: {finding.detail}; nothing was put in place")
    part.rename(out)
    return count
