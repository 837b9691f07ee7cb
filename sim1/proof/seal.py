"""Commitments: hashes of answers and films, told before anything is diagnosed, so that neither can be made to fit afterwards."""

import hashlib
import os
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import pydantic

from sim1.mismatch.strict_json import Strict
from sim1.stage import BadInput

NAME = "commitments.jsonl"
FILMS = ("bundles/", "unseen/")  # below a campaign's folder
LIST = "list"  # what the commitment to the drawn list is called


class Commitment(Strict):
    """One line of `commitments.jsonl`."""

    at: str  # UTC
    of: str  # a case, or `list`
    sha256: dict[str, str]  # file, from the campaign's folder -> hash of its bytes
    code_sha256: str  # of the diagnosing code as it was then


def sha256_of(path: Path) -> str:
    """SHA-256 of a file's bytes, as `sha256sum` prints it."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def code_sha256(package: Path, rooms: Sequence[str] = ("mismatch", "cloth", "recording")) -> str:
    """SHA-256 over names and hashes of all Python files, and of thresholds, in some rooms of a package."""
    files = sorted(path for room in rooms for kind in ("*.py", "*.yaml") for path in (package / room).rglob(kind))
    lines = [f"{sha256_of(path)}  {path.relative_to(package).as_posix()}\n" for path in files]
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def commit(root: Path, of: str, files: Sequence[Path], code: str) -> Commitment:
    """Add a line about `files` below `root`; one that says the same of the same files is returned as it stands.

    Raises:
        BadInput: there is a line about `of`, and the files are no longer those.
    """
    for known in read_commitments(root):
        if known.of == of:
            check(root, known)
            return known
    made = Commitment(
        at=datetime.now(UTC).isoformat(timespec="seconds"),
        of=of,
        sha256={path.relative_to(root).as_posix(): sha256_of(path) for path in files},
        code_sha256=code,
    )
    path, part = root / NAME, root / f"{NAME}.part"
    before = path.read_text() if path.is_file() else ""
    with part.open("w") as file:
        file.write(before + made.model_dump_json() + "\n")
        file.flush()
        os.fsync(file.fileno())
    part.replace(path)
    return made


def read_commitments(root: Path) -> tuple[Commitment, ...]:
    """All lines, oldest first; none where there is no file.

    Raises:
        BadInput: a line is damaged.
    """
    path = root / NAME
    found = []
    for number, line in enumerate(path.read_text().splitlines() if path.is_file() else [], start=1):
        try:
            found.append(Commitment.model_validate_json(line))
        except pydantic.ValidationError as error:
            raise BadInput(f"{path}: line {number} is damaged; restore the file") from error
    return tuple(found)


def check(root: Path, commitment: Commitment) -> None:
    """See that the files are still those that were committed to, and that a film has no other.

    Raises:
        BadInput: a file is missing, has changed or came since; it is named.
    """
    for name, hashed in commitment.sha256.items():
        path = root / name
        if not path.is_file():
            raise BadInput(f"{path}: committed to at {commitment.at} and gone")
        if sha256_of(path) != hashed:
            raise BadInput(f"{path}: changed since it was committed to at {commitment.at}; its SHA-256 was {hashed}")
    folders = [root / films / commitment.of for films in FILMS] if covers_films(commitment) else []
    for path in sorted(path for folder in folders for path in folder.rglob("*")):
        if path.is_file() and path.relative_to(root).as_posix() not in commitment.sha256:
            raise BadInput(f"{path}: came after the film was committed to at {commitment.at}; remove it")


def check_committed(root: Path, of: str, answers: Sequence[Path]) -> None:
    """See that just these answers were committed to, and that they and the films committed to with them are unchanged.

    A commitment of earlier code is to answers alone (`covers_films`): of its films nothing can be checked.

    Raises:
        BadInput: no commitment, one to other answers, or a file that has changed or is gone; it is named.
    """
    known = next((one for one in read_commitments(root) if one.of == of), None)
    names = {path.relative_to(root).as_posix() for path in answers}
    if known is None or {name for name in known.sha256 if not name.startswith(FILMS)} != names:
        raise BadInput(f"{answers[0]}: {root / NAME} holds no commitment to it")
    check(root, known)


def covers_films(commitment: Commitment) -> bool:
    """Whether a commitment to a case is also to what the diagnosis is given."""
    return any(name.startswith(FILMS) for name in commitment.sha256)
