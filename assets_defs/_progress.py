"""How far a command is that does one long thing: a bar on a terminal, a line a minute in a log."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

LINE_S = 60.0  # between lines of a log

type Tell = Callable[[float, str], None]


@contextmanager
def bar(total: float) -> Iterator[Tell]:
    """Yields `tell(done, what)`; time passed and time left stand beside it."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lines(total, lambda line: print(line, file=console.file, flush=True), time.monotonic)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as shown:
        task = shown.add_task("reading", total=total)
        yield lambda done, what: shown.update(task, completed=done, description=what)


def lines(total: float, say: Callable[[str], None], clock_s: Callable[[], float]) -> Tell:
    """`tell` that says a line at most every `LINE_S`, none in the first."""
    began_s = said_s = clock_s()

    def tell(done: float, what: str) -> None:
        nonlocal said_s
        now_s = clock_s()
        if now_s - said_s < LINE_S:
            return
        said_s, passed_s = now_s, now_s - began_s
        left = f", about {passed_s * (total - done) / done / 60:.0f} min left" if done > 0 else ""
        say(f"{100 * done / total:.0f} % after {passed_s / 60:.0f} min{left}: {what}")

    return tell
