"""A file is there whole or not at all, whenever its writing ends."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A temporary name beside `path` to write to, put in its place in the end; on an error what was there before stays, and no more.

    A process that is killed leaves the temporary name behind, and the next writing goes over it.
    """
    part = path.with_name(f"{path.name}.part")
    try:
        yield part
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
