"""Cases that a benchmark asks about: of the laboratory, or of a campaign whose answers are open."""

import json
from collections.abc import Callable, Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any

from sim1.proof.answers import Answers, read_answers
from sim1.recording.bundle import Bundle, read_bundle
from sim1.stage import BadInput
from sim1.whole_file import whole_file


def bundle_of(folder: Path) -> Path:
    """FOLDER/bundle as `python -m benchmarks.concealed many` writes it, or DIR/bundles/CASE itself."""
    return folder / "bundle" if (folder / "bundle").is_dir() else folder


def answers_of(folder: Path) -> Answers:
    """What was concealed: FOLDER/answers.json, or DIR/answers/CASE.json of DIR/bundles/CASE; raises BadInput."""
    if folder.parent.name == "bundles":
        return read_answers(folder.parent.parent / "answers" / f"{folder.name}.json")
    return read_answers(folder / "answers.json")


def each_once[Found](
    folders: list[Path], out: Path, what: str, ask: Callable[[Bundle], Found], tell: Callable[[str], None]
) -> Iterator[tuple[Answers, Found]]:
    """What was concealed and what was found in each case; writes OUT/CASE.json, and asks no case twice.

    Args:
        folders: the cases.
        out: where answers are kept.
        what: the question; answers to another one are refused.
        ask: finds the answer.
        tell: progress.

    Raises:
        BadInput: answers that are missing or damaged, cases of one name, or OUT/CASE.json is of another question or of another film;
            before any case is asked.
    """
    given = [(folder, answers_of(folder), out / f"{folder.name}.json") for folder in folders]
    for folder, answers, path in given:
        if any(other.name == folder.name and other != folder for other in folders):
            raise BadInput(f"{folder}: another case is called {folder.name} too; ask them into folders of their own")
        if path.is_file() and (kept := _kept(path)["of"]) != (now := _of(what, folder, answers)):
            raise BadInput(f"{path} is of {kept}, asked is {now}; give another folder for --out, or remove it")
    for folder, answers, path in given:
        if not path.is_file():
            out.mkdir(parents=True, exist_ok=True)
            found = ask(read_bundle(bundle_of(folder)))
            with whole_file(path) as part:
                part.write_text(json.dumps({"of": _of(what, folder, answers), "found": found}))
            tell(f"{folder.name}: done")
        yield answers, _kept(path)["found"]


def _of(what: str, folder: Path, answers: Answers) -> dict[str, str]:
    """What an answer is of: the question, what was concealed, and the film."""
    film = sha256()
    for path in sorted(path for path in bundle_of(folder).rglob("*") if path.is_file()):
        film.update(path.relative_to(bundle_of(folder)).as_posix().encode() + path.read_bytes())
    concealed = " + ".join(effect.name for effect in answers.effects) or "nothing"
    return {"asked": what, "concealed": concealed, "film_sha256": film.hexdigest()}


def _kept(path: Path) -> dict[str, Any]:
    """An answer that was written earlier.

    Raises:
        BadInput: no answer of a benchmark of this kind.
    """
    try:
        kept = json.loads(path.read_text())
        return {"of": dict(kept["of"]), "found": kept["found"]}
    except (ValueError, KeyError, TypeError) as error:
        raise BadInput(
            f"{path}: not what a benchmark keeps ({error!r}); remove it, and the case is asked again"
        ) from error
