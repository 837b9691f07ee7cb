"""`sim1 clean`: what may be removed, and its removal."""

import shutil
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from assets_defs._store import JOINT, REGENERATING, Place, StoreError
from pipeline import Graph, Home

LEFTOVERS = (".failed.part", ".part", ".part.recipe", ".part.seconds", ".old", ".rejected", ".failed.json", ".lock")


def doomed(
    home: Home, graph: Graph, *, everything: bool, garments: Iterable[str] | None, stages: Iterable[str] | None
) -> tuple[list[Path], list[str]]:
    """Paths to remove: leftovers, artifacts of graph nodes or garments that no longer exist, and what the options name.

    Also a line for every artifact that is left alone, as a process is making it: a run from the UI, which holds its
    artifact's lock and no other. Who asks is `alone` until all of it is removed.

    Raises:
        ValueError: an unknown stage, or a garment that is neither there nor has left anything.
        StoreError: everything is to be removed, and a process is making an artifact.
    """
    if everything:
        _refuse_if_any_is_being_made(home)
        return [path for path in (home.store, home.state) if any(_but_lock(path))], []
    known = {node.id for node in graph.nodes.values()}
    if unknown := set(stages or []) - known:
        raise ValueError(f"--select {sorted(unknown)[0]}: there is no such stage; there are {sorted(known)}")
    keys = {JOINT, *home.garments()}
    for name in set(garments or []) - keys - {path.name for path in _inside(home)}:
        raise ValueError(
            f"--garment {name}: there is no such garment, and nothing made of it; there are {home.garments()}"
        )
    found = []
    held: dict[Place, str] = {}
    for path in _inside(home):
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
            at = _belongs_to(path)
            if at not in held:
                held[at] = _why_held(at)
    return [path for path in found if not held[_belongs_to(path)]], [why for why in held.values() if why]


def clean(home: Home, paths: Iterable[Path]) -> int:
    """Remove `paths` (all below the store or the state folder) but what a process has begun to make since.

    Returns the bytes that became free.

    Raises:
        StoreError: the whole store is to be removed, and a process has begun to make an artifact.
    """
    freed = 0
    of: dict[Place, list[Path]] = {}
    for path in paths:
        if home.store in path.parents:
            of.setdefault(_belongs_to(path), []).append(path)
        elif path in (home.store, home.state):
            _refuse_if_any_is_being_made(home)
            freed += sum(_remove(own) for own in _but_lock(path))
            # Last: until then, who comes to regenerate is kept out. Whoever comes now finds the folder, or makes it.
            (path / REGENERATING).unlink(missing_ok=True)
            with suppress(OSError):
                path.rmdir()
        else:
            raise ValueError(f"{path}: not below {home.store}")
    for at, own in of.items():
        with suppress(StoreError), at.locked():
            freed += sum(_remove(path) for path in own if path != at.lock)
            at.lock.unlink()  # last: until then, who comes for the artifact is kept out
    return freed


def _remove(path: Path) -> int:
    files = [path] if path.is_file() else [file for file in path.rglob("*") if file.is_file()]
    freed = sum(file.stat().st_size for file in files)
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
    return freed


def _but_lock(folder: Path) -> list[Path]:
    """What is in a folder but the lock that keeps others out while it is emptied."""
    return [path for path in folder.glob("*") if path.name != REGENERATING]


def _inside(home: Home) -> list[Path]:
    """Artifacts and what lies beside them."""
    return sorted([*home.store.glob("*/*"), *home.store.glob("variants/*/*/*")])


def _belongs_to(path: Path) -> Place:
    """The artifact that a path in the store is, or beside which it lies."""
    suffix = next((end for end in LEFTOVERS if path.name.endswith(end)), "")
    return Place(path.with_name(path.name.removesuffix(suffix)))


def _why_held(at: Place) -> str:
    """What a process does with the artifact; "": none does anything."""
    if at.lock.exists():  # else it would be made here
        try:
            with at.locked():
                pass
        except StoreError as error:
            return str(error)
    return ""


def _refuse_if_any_is_being_made(home: Home) -> None:
    for lock in (path for path in _inside(home) if path.name.endswith(".lock")):
        if why := _why_held(_belongs_to(lock)):
            raise StoreError(why)
