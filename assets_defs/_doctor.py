"""`sim1 doctor`: the machine's examination as a table or JSON."""

import json

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from pipeline import Home
from sim1.doctor import examine, healthy
from sim1.progress import listening


def print_doctor(home: Home, *, as_json: bool) -> int:
    """Print what works and what is missing; returns 1 when something required is missing."""
    with Progress(console=Console(stderr=True), transient=True) as bars:
        task = bars.add_task("examining", total=None)
        with listening(lambda done, total, what: bars.update(task, completed=done, total=total, description=what)):
            found = examine(home.root)
    if as_json:
        rows = [diagnosis.as_json() for diagnosis in found]
        print(json.dumps({"schema": "sim1.doctor/1", "ok": healthy(found), "found": rows}, indent=1))
        return int(not healthy(found))
    table = Table("", "what", "found", "how to get it")
    for diagnosis in found:
        mark = "[green]works" if diagnosis.ok else "[red]missing" if diagnosis.required else "[yellow]absent"
        table.add_row(mark, diagnosis.name, diagnosis.detail, "" if diagnosis.ok else diagnosis.remedy)
    Console().print(table)
    return int(not healthy(found))
