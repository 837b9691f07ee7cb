"""`commitments.jsonl`: what a campaign has told so far, a line each, only ever added to; each holds the hash of the one before it."""

import hashlib
import os
from datetime import UTC, datetime
from pathlib import Path

import pydantic

from sim1.mismatch.strict_json import Strict
from sim1.stage import BadInput
from sim1.whole_file import whole_file

NAME = "commitments.jsonl"


class Told(Strict):
    """What every line says."""

    before: str | None = None  # SHA-256 of the line before it; None: it is the first, or earlier code wrote it
    at: str  # UTC


class Commitment(Told):
    """To the list of cases, or to a case's answers and films before it is diagnosed."""

    of: str  # a case, or `list`
    sha256: dict[str, str]  # file, from the campaign's folder -> hash of its bytes
    code_sha256: str  # of the diagnosing code as it was then
    laboratory_sha256: str | None = None  # of the program that films; None: it has no file here, or was not asked yet


class Begun(Told):
    """A diagnosis begins: one that is tried again leaves a second line."""

    begun: str  # the case
    code_sha256: str  # of the diagnosing code


class Ended(Told):
    """A diagnosis has ended, well or not, and its models have foretold what they can."""

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
    path = root / NAME
    lines = path.read_bytes().splitlines(keepends=True) if path.is_file() else []
    chained = line.model_copy(update={"before": _hash(lines[-1]) if lines else None})
    added = chained.model_dump_json().encode() + b"\n"
    with whole_file(path) as part, part.open("wb") as file:
        file.writelines([*lines, added])
        file.flush()
        os.fsync(file.fileno())
    return _hash(added)


def read_lines(root: Path) -> tuple[Line, ...]:
    """All lines, oldest first; none where there is no file.

    Raises:
        BadInput: a line is damaged, or is not the one that came after the line before it.
    """
    path = root / NAME
    found, last = [], None
    for number, text in enumerate(path.read_bytes().splitlines(keepends=True) if path.is_file() else [], start=1):
        try:
            line = LINES.validate_json(text)
        except pydantic.ValidationError as error:
            raise BadInput(f"{path}: line {number} is damaged; restore the file") from error
        if line.before not in (None, last):
            raise BadInput(
                f"{path}: line {number} was added to a line of SHA-256 {line.before[:12]}; before it stands "
                f"{'none' if last is None else last[:12]}: lines were changed or taken out; restore the file"
            )
        found.append(line)
        last = _hash(text)
    return tuple(found)


def _hash(line: bytes) -> str:
    """As `sha256sum` of the line with its end."""
    return hashlib.sha256(line).hexdigest()


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
