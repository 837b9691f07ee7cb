"""`sim1 status`: stage x garment, each fresh, stale and why, missing, waiting or failed."""

import json

import dagster as dg
from rich.console import Console
from rich.table import Table

from assets_defs._produce import label
from assets_defs._recipe import Snapshot
from pipeline import Graph, Home

SHOWN = {
    "fresh": "[green]fresh",
    "stale": "[yellow]stale",
    "missing": "[dim]missing",
    "waiting": "[dim]waiting",
    "failed": "[red]failed",
}


def print_status(home: Home, graph: Graph, *, as_json: bool) -> None:
    """Print the state of every artifact."""
    with dg.DagsterInstance.get() as instance:
        snapshot = Snapshot(instance, graph, home)
        rows = [(node, key, snapshot.status(node, key)) for node, key in snapshot.artifacts()]
    if as_json:
        listed = [
            {"asset": node.id, "garment": key, "state": status.state, "why": status.why} for node, key, status in rows
        ]
        print(json.dumps({"schema": "sim1.status/1", "profile": graph.profile, "artifacts": listed}, indent=1))
        return
    console = Console()
    table = Table("stage", *snapshot.garments, "joint", title=f"profile {graph.profile}")
    for node in graph.nodes.values():
        states = {key: SHOWN[status.state] for other, key, status in rows if other is node}
        table.add_row(node.id, *(states.get(garment, "") for garment in snapshot.garments), states.get(None, ""))
    console.print(table)
    for node, key, status in rows:
        if status.state in ("stale", "failed"):
            console.print(f"{SHOWN[status.state]}[/] {label(node, key)}: {status.why}", highlight=False, soft_wrap=True)
