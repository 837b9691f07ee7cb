"""`sim1 clean`: what may be removed, and its removal."""

import shutil
from collections.abc import Iterable
from pathlib import Path

from assets_defs._store import JOINT
from pipeline import Graph, Home

LEFTOVERS = (".part", ".part.recipe", ".part.seconds", ".old", ".rejected", ".failed.json", ".failed.part", ".lock")


def doomed(
    home: Home, graph: Graph, *, everything: bool, garments: Iterable[str] | None, stages: Iterable[str] | None
) -> list[Path]:
    """Paths to remove: leftovers, artifacts of graph nodes or garments that no longer exist, and what the options name.

    Raises:
        ValueError: an unknown stage.
    """
    if everything:
        return [path for path in (home.store, home.state) if path.exists()]
    known = {node.id for node in graph.nodes.values()}
    if unknown := set(stages or []) - known:
        raise ValueError(f"--select {sorted(unknown)[0]}: there is no such stage; there are {sorted(known)}")
    keys = {JOINT, *home.garments()}
    found = []
    for path in sorted([*home.store.glob("*/*"), *home.store.glob("variants/*/*/*")]):
        id_ = path.parent.relative_to(home.store).as_posix().removeprefix("variants/")
        if id_ in ("variants",) or path.parent.parent == home.store / "variants":
            continue
        leftover = path.name.endswith(LEFTOVERS)
        orphan = id_ not in known or (path.is_dir() and path.name not in keys and not leftover)
        asked = (stages is not None and id_ in stages and (not garments or path.name in garments)) or (
            stages is None and garments is not None and path.name in garments
        )
        if leftover or orphan or asked:
            found.append(path)
    return found


def clean(home: Home, paths: Iterable[Path]) -> int:
    """Remove `paths` (all below the store or the state folder); returns the bytes that became free."""
    freed = 0
    for path in paths:
        if home.store not in (path, *path.parents) and home.state not in (path, *path.parents):
            raise ValueError(f"{path}: not below {home.store}")
        files = [path] if path.is_file() else [file for file in path.rglob("*") if file.is_file()]
        freed += sum(file.stat().st_size for file in files)
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
    return freed
