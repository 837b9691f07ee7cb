"""A bar on the terminal for commands that do one long thing."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def bar(total: float) -> Iterator[Callable[[float, str], None]]:
    """Yields `tell(done, what)`; time passed and time left stand beside the bar."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as shown:
        task = shown.add_task("reading", total=total)
        yield lambda done, what: shown.update(task, completed=done, description=what)
