"""Strict reading of the YAML files that people write."""

from pathlib import Path
from typing import Any

import yaml
from pydantic import TypeAdapter, ValidationError

from sim1.stage import BadInput


def read_data_file[T](path: Path, kind: type[T], schema: str) -> T:
    """Read a YAML file with a `schema:` line into a `stage_config` class.

    Raises:
        BadInput: no such file, not YAML, another schema, a key is unknown or missing, a value of another type.
    """
    try:
        document: Any = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"{path}: cannot be read ({error.strerror}); restore the file") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: not YAML ({error}); correct the file") from error
    if not isinstance(document, dict) or document.get("schema") != schema:
        found = document.get("schema") if isinstance(document, dict) else document
        raise BadInput(f"{path}: schema is {found!r}, expected {schema!r}")
    fields = {key: value for key, value in document.items() if key != "schema"}
    try:
        return TypeAdapter(kind).validate_python(fields)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise BadInput(
            f"{path}: {place}: {first['msg']} (found {str(first['input'])[:80]!r}); correct the file"
        ) from error
