"""YAML files that people write, read into a strict model: no key twice, no key unknown, no yes where a number belongs."""

from pathlib import Path

import pydantic

from sim1.data_file import read_yaml
from sim1.recording.problems import Several
from sim1.stage import BadInput


class Strict(pydantic.BaseModel):
    """Base of the models: frozen, unknown keys refused, numbers finite, and `true` is not 1."""

    model_config = pydantic.ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @pydantic.model_validator(mode="before")
    @classmethod
    def _no_truth_values(cls, values: object) -> object:
        if isinstance(values, dict):
            for key, value in values.items():
                if _holds_truth_value(value):
                    raise ValueError(f"{key} is a truth value (YAML reads yes, no, on and off as one)")
        return values


def _holds_truth_value(value: object) -> bool:
    return any(map(_holds_truth_value, value)) if isinstance(value, list) else isinstance(value, bool)


def read_strict[T: Strict](path: Path, model: type[T], what: str) -> T:
    """Read a YAML file into a model; `what` names the file's kind and schema for messages.

    Raises:
        BadInput: missing, not YAML, an unknown, missing or repeated key, a value of another type or out of range; names
            the key.
    """
    raw = read_yaml(path, f"expected {what}")
    try:
        return model.model_validate(raw)
    except pydantic.ValidationError as error:
        raise Several([_one(path, part, what) for part in error.errors()]) from error
    except RecursionError as error:
        raise BadInput(f"{path}: a value contains itself; write it out ({what})") from error


def _one(path: Path, part: dict, what: str) -> str:
    place = ".".join(str(step) for step in part["loc"]) or "top"
    given = str(part["input"])
    given = given if len(given) <= 80 else given[:77] + "..."
    return f"{path}: {place}: {part['msg']} (got {given}); see {what}"
