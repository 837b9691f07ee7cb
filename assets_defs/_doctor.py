"""`sim1 doctor`: the machine's examination as a table or JSON."""

import dataclasses
import json

from rich.console import Console
from rich.table import Table
from sim1.doctor import examine


def print_doctor(*, as_json: bool) -> int:
    """Print what works and what is missing; returns 1 when something required is missing."""
    found = examine()
    missing = [diagnosis for diagnosis in found if diagnosis.required and not diagnosis.ok]
    if as_json:
        rows = [dataclasses.asdict(diagnosis) for diagnosis in found]
        print(json.dumps({"schema": "sim1.doctor/1", "ok": not missing, "found": rows}, indent=1))
        return int(bool(missing))
    console, table = Console(), Table("", "what", "found", "how to get it")
    for diagnosis in found:
        mark = "[green]works" if diagnosis.ok else "[red]missing" if diagnosis.required else "[yellow]absent"
        table.add_row(mark, diagnosis.name, diagnosis.detail, "" if diagnosis.ok else diagnosis.remedy)
    console.print(table)
    return int(bool(missing))
