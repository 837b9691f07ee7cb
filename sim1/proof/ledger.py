"""`commitments.jsonl`: what a campaign has told so far, a line each, only ever added to."""

import hashlib
import os
from datetime import UTC, datetime
from pathlib import Path

import pydantic

from sim1.mismatch.strict_json import Strict
from sim1.stage import BadInput

NAME = "commitments.jsonl"


class Commitment(Strict):
    """To the list of cases, or to a case's answers and films before it is diagnosed."""

    at: str  # UTC
    of: str  # a case, or `list`
    sha256: dict[str, str]  # file, from the campaign's folder -> hash of its bytes
    code_sha256: str  # of the diagnosing code as it was then


class Begun(Strict):
    """A diagnosis begins: one that is tried again leaves a second line."""

    at: str  # UTC
    begun: str  # the case
    code_sha256: str  # of the diagnosing code


class Ended(Strict):
    """A diagnosis has ended, well or not, and its models have foretold what they can."""

    at: str  # UTC
    ended: str  # the case
    seconds: float | None
    error: str | None  # as in its record
    code_sha256: str  # of the diagnosing code as it began
    sha256: dict[str, str]  # every file that it wrote, from the campaign's folder -> hash of its bytes


type Line = Commitment | Begun | Ended

LINES = pydantic.TypeAdapter(Line)


def now() -> str:
    """The time that a line bears."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def sha256_of(path: Path) -> str:
    """SHA-256 of a file's bytes, as `sha256sum` prints it."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def hashes(root: Path, files: list[Path]) -> dict[str, str]:
    """Files by their names from `root`."""
    return {path.relative_to(root).as_posix(): sha256_of(path) for path in files}


def add(root: Path, line: Line) -> str:
    """Add a line, so that it is there as a whole or not at all; returns the SHA-256 of its bytes, to be published."""
    path, part = root / NAME, root / f"{NAME}.part"
    before, added = path.read_text() if path.is_file() else "", line.model_dump_json() + "\n"
    with part.open("w") as file:
        file.write(before + added)
        file.flush()
        os.fsync(file.fileno())
    part.replace(path)
    return hashlib.sha256(added.encode()).hexdigest()


def read_lines(root: Path) -> tuple[Line, ...]:
    """All lines, oldest first; none where there is no file.

    Raises:
        BadInput: a line is damaged.
    """
    path = root / NAME
    found = []
    for number, line in enumerate(path.read_text().splitlines() if path.is_file() else [], start=1):
        try:
            found.append(LINES.validate_json(line))
        except pydantic.ValidationError as error:
            raise BadInput(f"{path}: line {number} is damaged; restore the file") from error
    return tuple(found)


def check_files(root: Path, sha256: dict[str, str], said: str, folders: list[Path]) -> None:
    """See that files are those that were hashed, and that there is no other in `folders`; `said` is what was done then, and when.

    Raises:
        BadInput: a file is missing, has changed or came since; it is named.
    """
    for name, hashed in sha256.items():
        path = root / name
        if not path.is_file():
            raise BadInput(f"{path}: {said} and gone; restore it")
        if sha256_of(path) != hashed:
            raise BadInput(f"{path}: changed since it was {said}; its SHA-256 was {hashed}; restore it")
    for path in sorted(path for folder in folders for path in folder.rglob("*")):
        if path.is_file() and path.relative_to(root).as_posix() not in sha256:
            raise BadInput(f"{path}: came after the others were {said}; remove it")
