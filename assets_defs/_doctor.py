"""`sim1 doctor`: the machine's examination as a table or JSON."""

import json
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from pipeline import Home
from sim1.doctor import examine, healthy
from sim1.progress import listening


def print_doctor(home: Home, *, as_json: bool) -> int:
    """Print what works and what is missing; returns 1 when something required is missing."""
    if as_json:
        found = examine(home.root)
        rows = [diagnosis.as_json() for diagnosis in found]
        print(json.dumps({"schema": "sim1.doctor/1", "ok": healthy(found), "found": rows}, indent=1))
        return int(not healthy(found))
    with _progress(Console(stderr=True)):
        found = examine(home.root)
    table = Table("", "what", "found", "how to get it")
    for diagnosis in found:
        mark = "[green]works" if diagnosis.ok else "[red]missing" if diagnosis.required else "[yellow]absent"
        table.add_row(mark, diagnosis.name, diagnosis.detail, "" if diagnosis.ok else diagnosis.remedy)
    Console().print(table)
    return int(not healthy(found))


@contextmanager
def _progress(console: Console) -> Iterator[None]:
    """A bar on a terminal, elsewhere a line per step: packages are imported one by one, which takes a minute or two."""
    columns = (BarColumn(bar_width=24), TextColumn("{task.description}"))
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as bars:
        task = bars.add_task("", total=None)

        def show(done: float, total: float, what: str) -> None:
            line = f"{done:g} of {total:g} examined, now {what}"
            bars.update(task, completed=done, total=total, description=line)
            if what and not console.is_terminal:
                console.print(line, highlight=False, soft_wrap=True)

        with listening(show):
            yield
