"""Progress of long work, reported to whoever listens (a progress bar, a run's log, nobody).

Stages call `report` or wrap a loop in `track`; they never print.
"""

from collections.abc import Callable, Iterable, Iterator, Sized
from contextlib import contextmanager
from contextvars import ContextVar

type Sink = Callable[[float, float, str], None]
"""Called with (done, total, what)."""

_sink: ContextVar[Sink | None] = ContextVar("progress_sink", default=None)


@contextmanager
def listening(sink: Sink) -> Iterator[None]:
    """Send progress reported inside the block to `sink`."""
    token = _sink.set(sink)
    try:
        yield
    finally:
        _sink.reset(token)


@contextmanager
def within(begin: float, end: float) -> Iterator[None]:
    """What is reported inside the block is a part of the work: from share `begin` of the whole to share `end`."""
    whole = _sink.get()

    def part(done: float, total: float, what: str) -> None:
        if whole is not None:
            whole(begin + (end - begin) * (done / total if total else 0.0), 1.0, what)

    with listening(part):
        yield


@contextmanager
def overheard(also: Sink) -> Iterator[None]:
    """What is reported inside the block is told to `also` besides whoever listens."""
    whole = _sink.get()

    def both(done: float, total: float, what: str) -> None:
        also(done, total, what)
        if whole is not None:
            whole(done, total, what)

    with listening(both):
        yield


def report(done: float, total: float, what: str = "") -> None:
    """Say that `done` of `total` units of the stage's work are finished."""
    if (sink := _sink.get()) is not None:
        sink(done, total, what)


def track[T](items: Iterable[T], what: str = "", total: int | None = None) -> Iterator[T]:
    """Yield `items`, reporting after each one. `total` is needed where the iterable has no length."""
    count = total if total is not None else len(items) if isinstance(items, Sized) else 0
    for done, item in enumerate(items):
        report(done, count, what)
        yield item
    report(count, count, what)
