"""Folders of cases: of the laboratory, or of a campaign whose answers are open."""

import json
from pathlib import Path

from sim1.proof.answers import Answers, read_answers
from sim1.proof.draw import Case


def bundle_of(folder: Path) -> Path:
    """FOLDER/bundle as `python -m benchmarks.concealed many` writes it, or DIR/bundles/CASE itself."""
    return folder / "bundle" if (folder / "bundle").is_dir() else folder


def answers_path(folder: Path) -> Path:
    """FOLDER/answers.json, or DIR/answers/CASE.json of DIR/bundles/CASE."""
    if folder.parent.name == "bundles":
        return folder.parent.parent / "answers" / f"{folder.name}.json"
    return folder / "answers.json"


def answers_of(folder: Path) -> Answers:
    """What was concealed.

    Raises:
        FileNotFoundError: no answers; the message names the file.
    """
    path = answers_path(folder)
    return read_answers(path, Case(**json.loads(path.read_text())["case"]))
