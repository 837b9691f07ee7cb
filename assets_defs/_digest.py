"""Content digests of files, folders and JSON values."""

import hashlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

RECORD = "artifact.json"  # what the store knows of an artifact; lies inside it and is no part of its content


def digest_json(value: Any) -> str:
    """Digest of a JSON value: 16 hex digits, independent of the order of keys."""
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()[:16]


def digest_file(path: Path) -> str:
    """SHA-256 of a file's bytes, whole."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def content_files(path: Path) -> Iterator[tuple[str, Path]]:
    """Names and paths of a folder's files, in order; a file counts as a folder of itself.

    Links are followed, as stages follow them: what they lead to is content of the folder.
    """
    if path.is_file():
        yield path.name, path
        return
    for file in sorted(_files_below(path)):
        name = file.relative_to(path).as_posix()
        if name != RECORD and not file.name.startswith("."):
            yield name, file


def _files_below(folder: Path, above: tuple[tuple[int, int], ...] = ()) -> Iterator[Path]:
    try:
        stat, inside = folder.stat(), list(folder.iterdir())
    except OSError:  # gone meanwhile, or not ours to read, as `lost+found` of a drive
        return
    if (itself := (stat.st_dev, stat.st_ino)) in above:  # a link back, below which all comes again
        return
    for path in inside:
        if path.is_dir():
            yield from _files_below(path, (*above, itself))
        elif path.is_file():
            yield path


def digest_files(files: dict[str, str]) -> str:
    """Digest of a folder from the digests of its files by name."""
    return digest_json(sorted(files.items()))


_seen: dict[Path, tuple[int, int, str]] = {}


def digest_path(path: Path) -> str:
    """Digest of a file or folder of inputs; a file that keeps its size and time is not read twice by one process."""
    found = {}
    for name, file in content_files(path):
        stat = file.stat()
        known = _seen.get(file)
        if known is None or known[:2] != (stat.st_size, stat.st_mtime_ns):
            known = _seen[file] = (stat.st_size, stat.st_mtime_ns, digest_file(file))
        found[name] = known[2]
    return digest_files(found)
