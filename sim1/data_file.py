"""Strict reading of the YAML files that people write."""

from pathlib import Path
from typing import Any

import yaml
from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError

from sim1.stage import BadInput
from sim1.unique_keys import UniqueKeys


class Strict(BaseModel):
    """Base of models of files: frozen, unknown keys refused, numbers finite."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def read_yaml(path: Path, remedy: str = "restore the file") -> Any:
    """What a YAML file holds; `remedy` says what to do where there is none to read.

    Raises:
        BadInput: no such file, not UTF-8, not YAML, no such date, a key there twice; names the line where there is one.
    """
    try:
        return yaml.load(path.read_text(encoding="utf-8"), Loader=UniqueKeys)
    except OSError as error:
        raise BadInput(f"{path}: cannot be read ({error.strerror}); {remedy}") from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        said = " ".join(str(error).split()).replace('in "<unicode string>", ', "")
        raise BadInput(f"{path}: not readable as YAML ({said}); correct the file") from error


def read_data_file[T](path: Path, kind: type[T], schema: str) -> T:
    """Read a YAML file with a `schema:` line into a `stage_config` class.

    Raises:
        BadInput: no such file, not YAML, another schema, a key is unknown, missing or there twice, a value of another type.
    """
    document = read_yaml(path)
    remedy = f"write schema: {schema} as its first line, and the rest as the files beside it and docs/ have it"
    if not isinstance(document, dict):
        raise BadInput(f"{path}: the file is {document!r:.80}, not lines of the form 'key: value'; {remedy}")
    if document.get("schema") != schema:
        raise BadInput(f"{path}: schema is {document.get('schema')!r}, expected {schema!r}; {remedy}")
    fields = {key: value for key, value in document.items() if key != "schema"}
    try:
        return TypeAdapter(kind).validate_python(fields)
    except ValidationError as error:
        raise BadInput(f"{path}: {explained(error)}") from error


def explained(error: ValidationError) -> str:
    """What is wrong with which key, in one line for the person who wrote the file."""
    said = []
    items = error.errors()
    for item in items:
        here = item["loc"]
        if any(len(other["loc"]) > len(here) > 0 and other["loc"][: len(here)] == here for other in items):
            continue  # at fault because something inside it is
        place = ".".join(str(part) for part in here)
        match item["type"]:
            case _ if not place:
                said.append(item["msg"])
            case "unexpected_keyword_argument" | "extra_forbidden":
                said.append(f"unknown key {place!r}; remove it or correct its spelling")
            case "missing" | "missing_argument" | "missing_keyword_only_argument":
                said.append(f"key {place!r} is missing")
            case "model_type":
                said.append(f"{place} is {item['input']!r:.80}, not keys and values")
            case _:
                said.append(f"{place} is {item['input']!r:.80}: {item['msg'].lower()}")
    return "; ".join(said)
