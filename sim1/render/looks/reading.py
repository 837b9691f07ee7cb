"""Strict reading of the files of looks: every fault names file, entry, key, value and remedy."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from sim1.data_file import read_data_file
from sim1.render.looks.blocks import Block, Kinds, Limits, Whole
from sim1.stage import BadInput


@dataclass(frozen=True)
class Range:
    """Numbers from `low` to `high`, all alike probable."""

    low: float
    high: float

    def draw(self, stream: np.random.Generator) -> float:
        return float(self.low + (self.high - self.low) * stream.random())


@dataclass(frozen=True)
class WholeRange:
    """Some whole numbers, all alike probable."""

    numbers: tuple[int, ...]

    @property
    def low(self) -> float:
        return float(self.numbers[0])

    @property
    def high(self) -> float:
        return float(self.numbers[-1])

    def draw(self, stream: np.random.Generator) -> float:
        return float(self.numbers[int(len(self.numbers) * stream.random())])


@dataclass(frozen=True)
class BlockEntry:
    """A kind with the ranges of its numbers."""

    kind: str
    ranges: Mapping[str, Range | WholeRange]

    def draw(self, stream: np.random.Generator) -> Block:
        return Block(kind=self.kind, values={name: span.draw(stream) for name, span in self.ranges.items()})


@dataclass(frozen=True)
class Entry:
    """A value of a file, with the way to it."""

    path: Path
    keys: tuple[str, ...]
    value: Any

    def fault(self, said: str) -> BadInput:
        return BadInput(f"{self.path}: {'.'.join(self.keys) or 'the file'} is {self.value!r:.80}: {said}")

    def fields(self, required: tuple[str, ...] = (), optional: tuple[str, ...] = ()) -> dict[str, "Entry"]:
        """The mapping's entries.

        Raises:
            BadInput: not a mapping, a key is unknown or missing.
        """
        if isinstance(self.value, dict) and not self.value and required:
            raise self.fault(f"it is empty; write the keys {', '.join(required)}")
        found = self.named()
        known = (*required, *optional)
        for key, entry in found.items():
            if key not in known:
                raise entry.fault(f"the key {key!r} is unknown; remove it, or write one of {', '.join(known)}")
        for key in required:
            if key not in found:
                raise self.fault(f"the key {key!r} is missing; add it")
        return found

    def named(self) -> dict[str, "Entry"]:
        """The mapping's entries, whatever their names.

        Raises:
            BadInput: not a mapping, empty, or a key is no text: a number and the same in quotes would be one name.
        """
        if not isinstance(self.value, dict) or not self.value:
            raise self.fault("expected lines of the form 'key: value'")
        for key in self.value:
            if not isinstance(key, str):
                raise self.fault(f"the key {key!r} is no text; put it in quotes")
        return {key: Entry(self.path, (*self.keys, key), value) for key, value in self.value.items()}

    def listed(self, least: int, most: int) -> Iterator["Entry"]:
        """The list's entries.

        Raises:
            BadInput: not a list, or of another length than `least` to `most`.
        """
        if not isinstance(self.value, list) or not least <= len(self.value) <= most:
            raise self.fault(f"expected a list of {least} to {most} entries")
        for number, value in enumerate(self.value):
            yield Entry(self.path, (*self.keys, str(number)), value)

    def range(self, limits: Limits | Whole) -> Range | WholeRange:
        """A number, or [low, high], within limits.

        Raises:
            BadInput: neither, or outside the limits; a fraction where whole numbers alone make sense.
        """
        if isinstance(limits, Whole):
            return self._whole_range(limits)
        ends = self.value if isinstance(self.value, list) else [self.value, self.value]
        numbers = all(isinstance(end, int | float) and not isinstance(end, bool) and isfinite(end) for end in ends)
        low, high = limits
        if len(ends) != 2 or not numbers or not low <= ends[0] <= ends[1] <= high:
            raise self.fault(f"expected a number or [low, high] within {low:g} to {high:g}")
        return Range(float(ends[0]), float(ends[1]))

    def _whole_range(self, limits: Whole) -> WholeRange:
        ends = self.value if isinstance(self.value, list) else [self.value, self.value]
        known = all(isinstance(end, int) and not isinstance(end, bool) and end in limits.numbers for end in ends)
        if len(ends) != 2 or not known or ends[0] > ends[1]:
            raise self.fault(f"expected one of {', '.join(map(str, limits.numbers))}, or [low, high] of these")
        return WholeRange(tuple(number for number in limits.numbers if ends[0] <= number <= ends[1]))

    def block(self, kinds: Kinds, more: Mapping[str, Limits | Whole] | None = None) -> BlockEntry:
        """A kind with its numbers, and those of `more`, which every kind has here.

        Raises:
            BadInput: an unknown kind; a number is unknown, missing or outside its limits.
        """
        kind = self.named().get("kind")
        if kind is None or not isinstance(kind.value, str) or kind.value not in kinds.limits:
            raise (kind or self).fault(f"there is no such {kinds.what}; write kind: {', '.join(kinds.limits)}")
        limits = {**kinds.limits[kind.value], **(more or {})}
        fields = self.fields(("kind", *limits))
        return BlockEntry(kind.value, {name: fields[name].range(span) for name, span in limits.items()})


def read_entries(path: Path, schema: str, *names: str) -> dict[str, Entry]:
    """The entries under the top-level keys `names` of a file.

    Raises:
        BadInput: not readable, another schema, a name twice, a key unknown or missing.
    """
    return Entry(path, (), read_data_file(path, dict[str, Any], schema)).fields(names)
