"""Compiled code on disk that is older than the loops is forgotten.

numba compares a compiled function with its own file alone. The loops call one another across files and take their constants from
there: a change of `forces.py` would leave the forces in Newton's step as they were.
"""

from pathlib import Path

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
