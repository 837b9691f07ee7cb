"""What every stage of the pipeline is: a pure function from artifacts to one artifact.

    def garment_mesh(inputs: Inputs, out: Path, config: GarmentMeshConfig) -> Facts

`inputs` maps a stage (or a named source) to its artifacts, one folder per garment, or one under "" where the stage
exists once. `out` is an empty folder that the caller renames into place when the function has returned. What it
returns are the facts that a person wants to see beside the artifact.
"""

import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, dataclass_transform

import pydantic.dataclasses
from pydantic import ConfigDict

if TYPE_CHECKING:
    import numpy as np

type Inputs = Mapping[str, Mapping[str, Path]]
"""Stage or source name -> garment ("" for a joint artifact) -> folder or file."""

type Facts = dict[str, Any]
"""JSON values: numbers with the unit in the name, strings, or a list of flat rows (shown as a table)."""


@dataclass_transform(kw_only_default=True, frozen_default=True)
def stage_config[T](cls: type[T]) -> type[T]:
    """Make a class a stage's configuration: frozen, keyword-only, checked, unknown keys refused.

    A setting that changes no byte of the artifact, such as how many processes make it, is no part of its recipe where its field
    says `exclude=True`.
    """
    config = ConfigDict(extra="forbid", strict=False)
    return pydantic.dataclasses.dataclass(frozen=True, kw_only=True, config=config)(cls)


def distinct[T](values: tuple[T, ...]) -> tuple[T, ...]:
    """The same, for settings in which a value twice would do work twice.

    Raises:
        ValueError: a value stands there twice.
    """
    if twice := sorted({repr(value) for value in values if values.count(value) > 1}):
        raise ValueError(f"{', '.join(twice)} more than once; name each once")
    return values


class BadInput(ValueError):
    """The input is at fault, not the program: the message names the file, the place, the value and the remedy."""


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One answer of a stage's check of its own artifact."""

    name: str  # snake_case, the same whether it passed or not
    passed: bool
    detail: str  # measured value, limit and unit, for a person
    blocking: bool = True  # a failed blocking check keeps the artifact out of the store


def only(inputs: Inputs, name: str) -> Path:
    """The one artifact of stage `name`: the joint one, or that of the garment at hand.

    Raises:
        BadInput: when there is none, or more than one.
    """
    found = inputs.get(name, {})
    if len(found) != 1:
        raise BadInput(f"stage input {name!r}: expected one artifact, got {sorted(found) or 'none'}")
    return next(iter(found.values()))


def garment_of(inputs: Inputs) -> str:
    """Name of the garment that a per-garment stage works on."""
    names = {key for artifacts in inputs.values() if len(artifacts) == 1 for key in artifacts if key}
    if len(names) != 1:
        raise BadInput(f"expected inputs of one garment, got {sorted(names) or 'none'}")
    return names.pop()


def random_stream(seed: int, *names: str | int) -> "np.random.Generator":
    """Independent random stream for a purpose, the same on every machine: `random_stream(seed, "towel", 17)`."""
    import numpy as np

    words = [zlib.crc32(str(name).encode()) for name in names]
    return np.random.default_rng([seed, *words])
