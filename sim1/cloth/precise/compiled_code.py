"""Compiled code on disk: what is older than the loops is forgotten, and of several processes one compiles.

numba compares a compiled function with its own file alone. The loops call one another across files and take their constants from
there: a change of `forces.py` would leave the forces in Newton's step as they were.
"""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

COMPILED_LAST = ("newton.newton", "twins.answers", "march.finish")  # once these are on disk, nearly all is
FLAGS = {"contract", "reassoc", "nsz", "arcp"}  # of arithmetic: all but what NaN and infinity would change
CONSTANTS = "arrays.py"  # holds no loop, but the columns that loops were compiled with


def forget_stale(folder: Path) -> None:
    """Remove numba's files in `folder/__pycache__` that are older than any compiled loop of the folder.

    Code that numba keeps elsewhere, where the folder cannot be written or NUMBA_CACHE_DIR is set, is not found.
    """
    loops = [path for path in folder.glob("*.py") if path.name == CONSTANTS or "@njit" in path.read_text("utf-8")]
    newest = max((path.stat().st_mtime_ns for path in loops), default=0)
    for path in (folder / "__pycache__").glob("*.nb[ci]"):
        try:
            if path.stat().st_mtime_ns < newest:
                path.unlink()
        except OSError:  # another process was faster, or the folder is not ours to write in
            continue


@contextmanager
def one_compiles(folder: Path) -> Iterator[None]:
    """While loops of the folder are not on disk yet, one process at a time: the others wait, and load what it compiled.

    Compiling takes a minute of a core; the workers of a diagnosis, which begin together, would each spend it. Where numba keeps
    its files elsewhere (see above) nobody waits.
    """
    kept = folder / "__pycache__"
    if "NUMBA_CACHE_DIR" in os.environ or not os.access(kept, os.W_OK) or _all_there(kept):
        yield
        return
    with (kept / "compiling.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # ends with the process
        yield


def _all_there(kept: Path) -> bool:
    return all(any(kept.glob(f"{name}-*.nbi")) for name in COMPILED_LAST)
