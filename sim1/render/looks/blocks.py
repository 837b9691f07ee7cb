"""Building blocks of looks: a kind from a small set, with a few numbers.

A kind is a function whose keyword arguments are the numbers, registered together with the limits in which each makes sense.
Adding a kind is adding one such function; files can name it at once.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

type Limits = tuple[float, float]  # smallest and largest value that makes sense


@dataclass(frozen=True)
class Whole:
    """Whole numbers that make sense, in rising order."""

    numbers: Sequence[int]


@dataclass(frozen=True, kw_only=True)
class Block:
    """A kind with its numbers, as drawn."""

    kind: str
    values: Mapping[str, float]


class Kinds:
    """The kinds of one sort of block.

    Args:
        what: name of the sort, for messages.
    """

    def __init__(self, what: str):
        self.what = what
        self._functions: dict[str, Callable[..., Any]] = {}
        self.limits: dict[str, dict[str, Limits | Whole]] = {}  # kind -> name of a number -> its limits
        self.color_counts: dict[str, int] = {}  # kind -> how many colours it shows

    def kind[F: Callable[..., Any]](self, *, colors: int = 1, **limits: Limits | Whole) -> Callable[[F], F]:
        """Register the decorated function as the kind of its name."""

        def register(function: F) -> F:
            self._functions[function.__name__] = function
            self.limits[function.__name__] = limits
            self.color_counts[function.__name__] = colors
            return function

        return register

    def make(self, block: Block, *arguments: Any) -> Any:
        """Call the block's function with `arguments` and its own numbers."""
        return self._functions[block.kind](*arguments, **block.values)
