"""Datasets put together and taken apart, by LeRobot's own tools, with what this project writes beside them."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from sim1.dataset.beside import PROVENANCE, Beside, artifact_of, joined, read_provenance
from sim1.dataset.card import licenses_of, write_card
from sim1.dataset.check import check_lerobot
from sim1.dataset.quiet import quiet_libraries
from sim1.stage import BadInput, random_stream

NAME = "sim1/local"  # LeRobot wants an owner and a name; nothing is looked up under it
LIKE = (
    "only like is merged with like: write both with the same features, or take away what one has alone with "
    "`lerobot-edit-dataset --operation.type remove_feature`"
)


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
    for folder, root in zip(folders[1:], roots[1:], strict=True):
        if differs := unlike(_info(root), _info(roots[0])):
            raise BadInput(f"{folder}: not like {folders[0]}: {'; '.join(differs)}; {LIKE}")
    beside, licenses = (
        joined([_beside(folder, root) for folder, root in zip(folders, roots, strict=True)]),
        _licenses(folders),
    )
    with _part_of(out) as part:
        with quiet_libraries():
            try:
                merge_datasets([_open(root) for root in roots], NAME, output_dir=part / "lerobot")
            except ValueError as error:  # two video files under one feature that do not go into one
                raise BadInput(f"{', '.join(map(str, folders))}: LeRobot cannot merge them: {error}; {LIKE}") from error
        beside.write(part)
        _card(part, licenses)
        _require_sound(part)
    return sum(_info(root)["total_episodes"] for root in roots)


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
    root = _sound(folder)
    beside, licenses, count = _beside(folder, root), _licenses([folder]), _info(root)["total_episodes"]
    groups = np.arange(count) if beside.provenance is None else kindred(_sources(beside.provenance))
    parts = shared_out(groups, shares, seed)
    if empty := [name for name, episodes in parts.items() if not episodes]:
        raise BadInput(
            f"{folder}: {len(set(groups.tolist()))} groups of episodes without a common source cannot fill the parts "
            f"{list(shares)}: {', '.join(empty)} would be empty; make episodes from more demonstrations"
        )
    with _part_of(out) as part:
        with quiet_libraries():
            split_dataset(_open(root), parts, output_dir=part / "made")
        for name, episodes in parts.items():
            (part / name).mkdir()
            (part / "made" / name).rename(part / name / "lerobot")
            beside.of_episodes(episodes).write(part / name)
            _card(part / name, licenses)
        shutil.rmtree(part / "made")
        _require_sound(part)
    return {name: len(episodes) for name, episodes in parts.items()}


def _licenses(folders: Sequence[Path]) -> tuple[str, ...] | None:
    """Of all cards together; None where one has no card."""
    named = [licenses_of(artifact_of(folder)) for folder in folders]
    return None if None in named else tuple(dict.fromkeys(name for one in named for name in one))


def _card(out: Path, licenses: tuple[str, ...] | None) -> None:
    """A card of what was put together or taken apart, where all that went in has one: pictures and counts are its own, licenses those of all."""
    if licenses and (out / PROVENANCE).is_file():
        write_card(out, read_provenance(out / PROVENANCE), name=NAME, licenses=licenses)


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


def _info(root: Path) -> dict[str, Any]:
    return json.loads((root / "meta" / "info.json").read_text())


def _beside(folder: Path, root: Path) -> Beside:
    """What lies beside a dataset, a row of provenance for each of its episodes."""
    return Beside.of(folder, episode_count=_info(root)["total_episodes"])


def unlike(info: Mapping[str, Any], first: Mapping[str, Any]) -> list[str]:
    """In what a dataset's info.json differs from the first one's where LeRobot's merge wants both alike."""
    from lerobot.configs.video import VIDEO_ENCODER_INFO_KEYS

    differs = [
        f"{key} is {info.get(key)!r}, there {first.get(key)!r}"
        for key in ("fps", "robot_type")
        if info.get(key) != first.get(key)
    ]
    here, there = info["features"], first["features"]
    differs += [f"feature {name} is only here" for name in here if name not in there]
    differs += [f"feature {name} is only there" for name in there if name not in here]
    for name in (name for name in here if name in there):
        one, other = (_flat(features[name]) for features in (here, there))
        ignored = {f"info.{key}" for key in VIDEO_ENCODER_INFO_KEYS} if here[name]["dtype"] == "video" else ()
        for key in sorted({*one, *other} - {*ignored}):
            if one.get(key) != other.get(key):
                differs.append(f"feature {name}: {key} {_difference(one.get(key), other.get(key))}")
    return differs


def _flat(feature: Mapping[str, Any]) -> dict[str, Any]:
    info = feature.get("info")
    inner = {f"info.{key}": value for key, value in info.items()} if isinstance(info, dict) else {"info": info}
    return {**{key: value for key, value in feature.items() if key != "info"}, **inner}


def _difference(one: Any, other: Any) -> str:
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other) > 4:
        place = next(place for place, pair in enumerate(zip(one, other, strict=True)) if pair[0] != pair[1])
        return f"has {one[place]!r} at place {place}, there {other[place]!r}"
    return f"is {one!r:.80}, there {other!r:.80}"


def _open(root: Path):
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    return LeRobotDataset(NAME, root=root, video_backend="pyav")


@contextmanager
def _part_of(out: Path) -> Iterator[Path]:
    """A folder beside `out` that takes its place when the block has gone well, and goes away when it has not.

    Raises:
        BadInput: `out` exists, or cannot be made.
    """
    if out.exists():
        raise BadInput(f"{out}: exists; give another folder")
    part = out.with_name(f"{out.name}.part")
    try:
        shutil.rmtree(part, ignore_errors=True)  # of a run that was killed
        part.mkdir(parents=True)
    except OSError as error:
        raise BadInput(f"{part}: cannot be made ({error.strerror}); give another folder") from error
    try:
        yield part
        part.rename(out)
    except BaseException:  # an interrupt as well
        shutil.rmtree(part, ignore_errors=True)
        raise


def _require_sound(part: Path) -> None:
    """Check every dataset in `part`.

    Raises:
        BadInput: one is not sound. The given ones were, so the fault lies in what writes them.
    """
    for info in sorted(part.rglob("meta/info.json")):
        for finding in check_lerobot(info.parents[1]):
            if not finding.passed:
                raise BadInput(
                    f"{part}: what was made of sound datasets is not sound itself, {finding.name}: {finding.detail}; nothing was put in "
                    "place. That is a fault of this program or of the installed lerobot: `sim1 doctor` tells the versions to report it with"
                )
