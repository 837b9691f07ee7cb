"""Commitments: hashes of answers and films, told before anything is diagnosed, so that neither can be made to fit afterwards."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from sim1.proof.ledger import NAME, Commitment, Ended, add, check_files, hashes, now, read_lines
from sim1.stage import BadInput

FILMS = ("bundles/", "unseen/")  # below a campaign's folder
LIST = "list"  # what the commitment to the drawn list is called


def commit(
    root: Path, of: str, files: Sequence[Path], code: str, laboratory: str | None = None, *, made_anew: bool = False
) -> Commitment:
    """Add a line about `files` below `root`; one that says the same of the same files is returned as it stands.

    `code` and `laboratory` are the hashes of what diagnoses and of what films. With `made_anew`, the laboratory has just made the
    files again, as those committed to stayed on another machine, where rounding may differ: a further line says what they are now,
    unless the laboratory is another than it was (where that was told: earlier code did not), or a diagnosis of the earlier ones has ended.

    Raises:
        BadInput: there is a line about `of`, and the files are no longer those.
    """
    if (known := committed(root, of)) is not None:
        try:
            check(root, known)
            return known
        except BadInput as changed:
            if not made_anew or any(isinstance(line, Ended) and line.ended == of for line in read_lines(root)):
                raise
            if laboratory != known.laboratory_sha256 and known.laboratory_sha256 is not None:
                raise BadInput(
                    f"{changed}; it was filmed again by another laboratory ({(laboratory or 'no file of it is here')[:12]}) than the one that "
                    f"was committed to ({known.laboratory_sha256[:12]}): restore that one"
                ) from changed
    made = Commitment(at=now(), of=of, sha256=hashes(root, list(files)), code_sha256=code, laboratory_sha256=laboratory)
    add(root, made)
    return made


def read_commitments(root: Path) -> tuple[Commitment, ...]:
    """The commitments among the lines, oldest first; none where there is no file.

    Raises:
        BadInput: a line is damaged.
    """
    return tuple(line for line in read_lines(root) if isinstance(line, Commitment))


def committed(root: Path, of: str) -> Commitment | None:
    """The latest commitment to a case or to the list; None where there is none.

    Raises:
        BadInput: a line is damaged.
    """
    return next((one for one in reversed(read_commitments(root)) if one.of == of), None)


def made_again(commitments: Sequence[Commitment]) -> tuple[str, ...]:
    """Cases committed to more than once: their films were made again, and were others, before a diagnosis had ended."""
    times = Counter(one.of for one in commitments)
    return tuple(sorted(of for of, count in times.items() if count > 1))


def check(root: Path, commitment: Commitment, *, films: bool = True) -> None:
    """See that the files are still those that were committed to, and that a film has no other; without `films`, the answers alone.

    Raises:
        BadInput: a file is missing, has changed or came since; it is named.
    """
    asked = {name: one for name, one in commitment.sha256.items() if films or not name.startswith(FILMS)}
    folders = [root / place / commitment.of for place in FILMS] if films and covers_films(commitment) else []
    check_files(root, asked, f"committed to at {commitment.at}", folders)


def check_committed(root: Path, of: str, answers: Sequence[Path], *, films: bool = True) -> None:
    """See that just these answers were committed to, and that they and the films committed to with them are unchanged.

    A commitment of earlier code is to answers alone (`covers_films`): of its films nothing can be checked.

    Raises:
        BadInput: no commitment, one to other answers, or a file that has changed or is gone; it is named.
    """
    known = committed(root, of)
    names = {path.relative_to(root).as_posix() for path in answers}
    if known is None or {name for name in known.sha256 if not name.startswith(FILMS)} != names:
        raise BadInput(f"{answers[0]}: {root / NAME} holds no commitment to it; restore that file")
    check(root, known, films=films)


def covers_films(commitment: Commitment) -> bool:
    """Whether a commitment to a case is also to what the diagnosis is given."""
    return any(name.startswith(FILMS) for name in commitment.sha256)
