"""Who may work where: lock files that a killed process lets go of by itself."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO


class Taken(RuntimeError):
    """Another process holds the lock; `holder` is its number, or '?'."""

    def __init__(self, holder: str):
        super().__init__(f"held by process {holder}")
        self.holder = holder


@contextmanager
def exclusive(path: Path, *, patient: bool = False) -> Iterator[None]:
    """Hold the lock file `path`, which says who holds it; who is patient waits for it.

    Raises:
        Taken: another process holds it.
    """
    with _held(path, fcntl.LOCK_EX | (0 if patient else fcntl.LOCK_NB)) as file:
        file.seek(0)
        file.truncate()
        file.write(str(os.getpid()))
        file.flush()
        yield


@contextmanager
def shared(path: Path) -> Iterator[None]:
    """Hold the lock file `path` beside others who share it; waits for who holds it alone."""
    with _held(path, fcntl.LOCK_SH):
        yield


@contextmanager
def _held(path: Path, kind: int) -> Iterator[TextIO]:
    """A lock on a file that was removed since it was opened would keep nobody out: then the file that has its place is locked."""
    while True:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            file = path.open("a+")
        except FileNotFoundError:  # the folder was removed in between
            continue
        with file:
            try:
                fcntl.flock(file, kind)
            except BlockingIOError:
                file.seek(0)
                raise Taken(file.read().strip() or "?") from None
            if _is_at(path, file):
                yield file
                return


def _is_at(path: Path, file: TextIO) -> bool:
    try:
        return os.path.samestat(path.stat(), os.fstat(file.fileno()))
    except FileNotFoundError:
        return False
