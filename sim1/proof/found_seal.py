"""What a diagnosis wrote, sealed when it ends: neither changed afterwards nor had by trying again unnoticed."""

from collections.abc import Iterable
from pathlib import Path

from sim1.mismatch.strict_json import Strict
from sim1.proof.files import Files, Record
from sim1.proof.ledger import NAME, Begun, Ended, Line, add, check_files, hashes, now, read_lines
from sim1.stage import BadInput


class Diagnosed(Strict):
    """What the lines about diagnoses say of the cases."""

    unsealed: tuple[str, ...]  # scored cases that earlier code diagnosed: of what was found there is no hash
    begun_twice: tuple[str, ...]  # without an end between: interrupted, or tried again
    again: tuple[str, ...]  # begun after an end


def begin(files: Files, case: str, code: str) -> None:
    """Tell that a diagnosis begins."""
    add(files.root, Begun(at=now(), begun=case, code_sha256=code))


def end(files: Files, record: Record) -> str:
    """Seal how a diagnosis ended and every file that it wrote; returns the SHA-256 of the line."""
    line = Ended(
        at=now(),
        ended=record.case,
        seconds=record.seconds,
        error=record.error,
        code_sha256=record.code_sha256,
        sha256=hashes(files.root, files.written(record.case)),
    )
    return add(files.root, line)


def check_found(files: Files, record: Record) -> None:
    """See that a case ended as its record says and that what was found is what was sealed; nothing where earlier code diagnosed it.

    Of a diagnosis that failed nothing is read but that it did, so that its files are not looked at.

    Raises:
        BadInput: no end of it, another end, or a file that changed, is gone or came since; it is named.
    """
    last = next((line for line in reversed(read_lines(files.root)) if _case(line) == record.case), None)
    if last is None:
        return
    if isinstance(last, Begun):
        raise BadInput(
            f"{files.root / NAME}: {record.case} began to be diagnosed at {last.at} and nothing says that it ended; restore the file"
        )
    if (record.seconds, record.error, record.code_sha256) != (last.seconds, last.error, last.code_sha256):
        raise BadInput(
            f"{files.record(record.case)}: says {record.seconds} s, error {record.error!r}, code {record.code_sha256[:12]}; sealed at {last.at} "
            f"were {last.seconds} s, error {last.error!r}, code {last.code_sha256[:12]}; restore it"
        )
    if record.error is None:
        check_files(files.root, last.sha256, f"sealed at {last.at}", files.findings(record.case))


def check_verdict(files: Files, case: str, path: Path) -> None:
    """See that a file that came along from where a case was diagnosed is the one that was sealed there.

    Raises:
        BadInput: no end of the case, or other files were sealed.
    """
    last = next(
        (line for line in reversed(read_lines(files.root)) if isinstance(line, Ended) and line.ended == case), None
    )
    name = path.relative_to(files.root).as_posix()
    if last is None or name not in last.sha256:
        raise BadInput(f"{files.root / NAME}: no line says that {name} was sealed; restore the file")
    check_files(files.root, {name: last.sha256[name]}, f"sealed at {last.at}", [])


def diagnosed(lines: Iterable[Line], scored: Iterable[str]) -> Diagnosed:
    """What is to be told of the `scored` cases, and of every case that was begun more than once."""
    open_, ended, twice, again = set[str](), set[str](), set[str](), set[str]()
    for line in lines:
        if isinstance(line, Begun):
            if line.begun in open_:
                twice.add(line.begun)
            elif line.begun in ended:
                again.add(line.begun)
            open_.add(line.begun)
        elif isinstance(line, Ended):
            open_.discard(line.ended)
            ended.add(line.ended)
    unsealed = tuple(case for case in scored if case not in ended)
    return Diagnosed(unsealed=unsealed, begun_twice=tuple(sorted(twice)), again=tuple(sorted(again)))


def _case(line: Line) -> str | None:
    """The case that a line about a diagnosis is of."""
    return line.begun if isinstance(line, Begun) else line.ended if isinstance(line, Ended) else None
