"""Where a command writes: tried before minutes of work rather than after, and each file whole or not at all."""

import tempfile
from collections.abc import Callable
from pathlib import Path

from sim1.stage import BadInput
from sim1.whole_file import whole_file


def writable_folder(folder: Path) -> None:
    """Make a folder that is missing, its parents too, and see that a file can be written in it.

    Raises:
        BadInput: it cannot be made, is no folder, or takes no file.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".tried_"):
            pass
    except OSError as error:
        raise BadInput(
            f"{folder}: cannot be written to ({error.strerror or error}); give another place for --out"
        ) from error


def writable_file(file: Path) -> None:
    """Make the folder of a file that is to be written.

    Raises:
        BadInput: as `writable_folder`, or a folder stands where the file shall be.
    """
    if file.is_dir():
        raise BadInput(f"{file}: is a folder; give a file for --out")
    writable_folder(file.parent)


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Have `write` write a file under a temporary name beside it, then put it in its place.

    Raises:
        BadInput: it cannot be written; what was there before stays.
    """
    try:
        with whole_file(path) as part:
            write(part)
    except OSError as error:
        raise BadInput(
            f"{path}: cannot be written ({error.strerror or error}); free some space or give another place for --out, and run again"
        ) from error
