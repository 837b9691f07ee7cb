"""Cases that a benchmark asks about: of the laboratory, or of a campaign whose answers are open."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path

from sim1.proof.answers import Answers, read_answers
from sim1.recording.bundle import Bundle, read_bundle


def bundle_of(folder: Path) -> Path:
    """FOLDER/bundle as `python -m benchmarks.concealed many` writes it, or DIR/bundles/CASE itself."""
    return folder / "bundle" if (folder / "bundle").is_dir() else folder


def answers_of(folder: Path) -> Answers:
    """What was concealed: FOLDER/answers.json, or DIR/answers/CASE.json of DIR/bundles/CASE; raises BadInput."""
    if folder.parent.name == "bundles":
        return read_answers(folder.parent.parent / "answers" / f"{folder.name}.json")
    return read_answers(folder / "answers.json")


def each_once[Found](
    folders: list[Path], out: Path, ask: Callable[[Bundle], Found], tell: Callable[[str], None]
) -> Iterator[tuple[Answers, Found]]:
    """What was concealed and what was found in each case; writes OUT/CASE.json, and asks no case twice.

    Raises:
        BadInput: answers that are missing or damaged, before any case is asked.
    """
    given = [(folder, answers_of(folder)) for folder in folders]
    for folder, answers in given:
        path = out / f"{folder.name}.json"
        if not path.is_file():
            out.mkdir(parents=True, exist_ok=True)
            part = path.with_name(f"{path.name}.part")
            part.write_text(json.dumps(ask(read_bundle(bundle_of(folder)))))
            part.replace(path)
            tell(f"{folder.name}: done")
        yield answers, json.loads(path.read_text())
