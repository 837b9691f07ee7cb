"""JSON that programs exchange, read into a strict model."""

import json
from pathlib import Path

import pydantic

from sim1.data_file import Strict, explained
from sim1.stage import BadInput


def read_json[T: Strict](path: Path, kind: type[T], remedy: str) -> T:
    """Read and check a file.

    Raises:
        BadInput: missing, not JSON, or not what the model asks for; ends with the remedy.
    """
    try:
        return kind.model_validate_json(path.read_bytes())
    except OSError as error:
        raise BadInput(f"{path}: not readable ({error.strerror}); {remedy}") from error
    except pydantic.ValidationError as error:
        raise BadInput(f"{path}: {explained(error)}; {remedy}") from error


def write_json(path: Path, content: Strict) -> None:
    """Write a model by the names of its schema."""
    path.write_text(json.dumps(content.model_dump(by_alias=True, mode="json"), indent=1) + "\n")
