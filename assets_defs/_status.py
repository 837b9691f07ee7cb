"""`sim1 status`: stage x garment, each fresh, stale and why, missing, waiting or failed."""

import json
from collections.abc import Iterator

import dagster as dg
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from assets_defs._recipe import Key, Snapshot, Status, label
from pipeline import Graph, Home, Node

STYLES = {"fresh": "green", "stale": "yellow", "missing": "dim", "waiting": "dim", "failed": "red"}
SYMBOLS = {
    "fresh": "✓",
    "stale": "~",
    "missing": "·",
    "waiting": "…",
    "failed": "✗",
}  # one column is one character wide
JOINT = "joint"
WIDEST = 12  # characters of a garment's name beside each other; longer ones go on below

type Row = tuple[Node, Key, Status]


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
    console = Console(highlight=False)
    legend = "  ".join(f"[{STYLES[state]}]{symbol} {state}[/]" for state, symbol in SYMBOLS.items())
    console.print(f"profile {graph.profile}    {legend}\n")
    for table in tables(graph, rows, [*snapshot.garments, JOINT], console.width):
        console.print(table)
    for node, key, status in rows:
        if status.state in ("stale", "failed"):
            line = f"[{STYLES[status.state]}]{status.state}[/] {label(node, key)}: {escape(status.why)}"
            console.print(line, soft_wrap=True)


def tables(graph: Graph, rows: list[Row], columns: list[str], width: int) -> Iterator[Table]:
    """Stages as rows, garments as columns; garments that do not fit beside each other go on in another table."""
    states = {(node.id, key or JOINT): status.state for node, key, status in rows}
    variants = sorted({node.variant or "" for node in graph.nodes.values()})
    lines: list[tuple[str, str]] = []  # what stands in front, node id or "" for a heading
    for variant in variants:
        lines += [(f"variant {variant}", "")] if variant else []
        own = [node for node in graph.nodes.values() if (node.variant or "") == variant]
        lines += [(f"  {node.stage.name}" if variant else node.stage.name, node.id) for node in own]
    front = max(len(text) for text, _ in lines)
    for part in _fitting(columns, width - front):
        table = Table(box=None, padding=(0, 2, 0, 0))
        table.add_column(overflow="fold")
        for column in part:
            table.add_column(column, justify="center", overflow="fold", max_width=WIDEST)
        for text, id_ in lines:
            cells = [states.get((id_, column)) for column in part]
            if any(cells) or not id_:
                table.add_row(text, *(f"[{STYLES[cell]}]{SYMBOLS[cell]}" if cell else "" for cell in cells))
        yield table


def _fitting(columns: list[str], width: int) -> Iterator[list[str]]:
    """Columns in as few parts as fit into `width` each, at least one a part."""
    part: list[str] = []
    for column in columns:
        if part and sum(min(len(other), WIDEST) + 2 for other in [*part, column]) > width - 2:
            yield part
            part = []
        part.append(column)
    yield part
