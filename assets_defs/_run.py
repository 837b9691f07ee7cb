"""`sim1 run`: the regeneration with progress bars and a summary."""

import time
from pathlib import Path

import dagster as dg
from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from assets_defs._recipe import Snapshot, label
from assets_defs._regenerate import Report, regenerate
from assets_defs._results import results, warnings
from assets_defs._store import StoreError
from assets_defs._summary import write_summary
from pipeline import Graph, Home, Node

WAITING_AT_MOST = 4  # lines


def selected(graph: Graph, stages: list[str] | None, variant: str | None) -> set[str]:
    """Node ids of the stages (of any variant, or of one) and everything that they need.

    Raises:
        ValueError: an unknown stage or variant, or a stage that the variant does not have.
    """
    if variant not in (None, "base", *graph.variants):
        raise ValueError(f"--variant {variant}: there are {['base', *graph.variants]}")
    names = {node.stage.name for node in graph.nodes.values()}
    for name in stages or []:
        if name not in names and name not in graph.nodes:
            raise ValueError(f"--select {name}: there is no such stage; there are {sorted(names)}")
    own = [node for node in graph.nodes.values() if variant is None or _is_of(node, variant)]
    for name in stages or []:
        if not any(name in (node.stage.name, node.id) for node in own):
            raise ValueError(
                f"--select {name}: --variant {variant} has no such stage of its own; it has "
                f"{sorted(node.stage.name for node in own)}"
            )
    return graph.ancestors({node.id for node in own if not stages or node.stage.name in stages or node.id in stages})


def _is_of(node: Node, variant: str) -> bool:
    if variant == "base":
        return node.variant is None and not node.stage.compares  # who compares needs every variant
    return node.variant == variant


class _Bars:
    """Observer that draws one bar for the whole and one for each artifact under way."""

    def __init__(self, console: Console):
        self.console = console
        self.bars = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=24),
            TextColumn("{task.fields[note]}"),
            TimeElapsedColumn(),
            console=console,
        )
        self.whole = self.bars.add_task("[bold]all", total=None, note="")
        self.tasks: dict[str, int] = {}
        self.failed: dict[str, str] = {}
        self.done = 0

    def plan(self, seconds_left: float, count_left: int) -> None:
        note = f"{count_left} to make, about {_duration(seconds_left)} left" if count_left else ""
        self.bars.update(self.whole, total=self.done + count_left, completed=self.done, note=note)

    def started(self, name: str) -> None:
        self.tasks[name] = self.bars.add_task(name, total=None, note="")
        if not self.console.is_terminal:
            self.console.print(f"{name}: started", highlight=False)

    def progress(self, name: str, done: float, total: float, what: str) -> None:
        task = self.bars.tasks[[task.id for task in self.bars.tasks].index(self.tasks[name])]
        left = f", {_duration(task.elapsed * (total - done) / done)} left" if done and total and task.elapsed else ""
        self.bars.update(self.tasks[name], completed=done, total=total or None, note=f"{what} {done:g}/{total:g}{left}")

    def finished(self, name: str, seconds: float, message: str) -> None:
        self.bars.remove_task(self.tasks.pop(name))
        self.done += not message
        self.failed.pop(name, None)
        if message:
            self.failed[name] = message
        mark = "[red]failed[/red]" if message else "[green]made[/green]"  # why is said once, at the end
        self.console.print(f"{name}: {mark} ({_duration(seconds)})", highlight=False, soft_wrap=True)

    def print_failures(self) -> None:
        for name, message in self.failed.items():
            self.console.print(f"[red]failed[/red] {name}: {escape(message)}", soft_wrap=True, highlight=False)


def run_with_progress(home: Home, graph: Graph, nodes: set[str], garments: list[str] | None, jobs: int) -> int:
    """Regenerate, draw progress, write the summary page, print where things are. Returns the exit code."""
    console = Console()
    began = time.monotonic()
    of_all = not garments and nodes == set(graph.nodes)
    bars = _Bars(console)
    with dg.DagsterInstance.get() as instance:
        try:
            with Live(bars.bars, console=console, refresh_per_second=4, transient=True):
                report = regenerate(
                    home, graph, instance, nodes=nodes, garments=garments, jobs=jobs, remember=of_all, observer=bars
                )
        except StoreError as error:
            console.print(f"[red]sim1: {error}")
            return 2
        except KeyboardInterrupt:
            bars.print_failures()
            console.print("interrupted; what was made is kept, `sim1 run` goes on from here")
            return 130
        snapshot = Snapshot(instance, graph, home)
        page = write_summary(snapshot)
        _print_summary(bars, snapshot, report, page, time.monotonic() - began)
    # Joint artifacts that wait for garments which were not asked for are no failure.
    return 1 if report.failed or (report.waiting and not garments) else 0


def _print_summary(bars: _Bars, snapshot: Snapshot, report: Report, page: Path, seconds: float) -> None:
    console, home, graph = bars.console, snapshot.home, snapshot.graph
    if report.made:
        table = Table("stage", "artifacts", "seconds", title="made")
        by_stage: dict[str, list[float]] = {}
        for name, taken in report.made.items():
            by_stage.setdefault(
                next(
                    id_
                    for id_ in sorted(graph.nodes, key=len, reverse=True)
                    if name == id_ or name.startswith(id_ + "/")
                ),
                [],
            ).append(taken)
        for id_, times in by_stage.items():
            table.add_row(id_, str(len(times)), f"{sum(times):.1f}")
        console.print(table)
    console.print(
        f"{len(report.made)} made, {report.fresh} fresh already, {len(report.failed)} failed, "
        f"{len(report.waiting)} waiting; profile {graph.profile}; {_duration(seconds)}"
    )
    if graph.profile != (kept := home.remembered_profile()):
        console.print(
            f"profile {graph.profile} was for this part alone: without --profile, commands keep to {kept}",
            soft_wrap=True,
        )
    bars.print_failures()
    if not report.failed:
        for name, why in list(report.waiting.items())[:WAITING_AT_MOST]:
            console.print(f"waiting {name}: {why}", soft_wrap=True, highlight=False)
    earlier = 0
    for node, key, said in warnings(snapshot):
        name = label(node, key)
        if name in report.made:
            console.print(f"[yellow]warning[/yellow] {name}: {escape(said)}", soft_wrap=True, highlight=False)
        earlier += name not in report.made
    if earlier:
        console.print(f"warnings on artifacts of earlier runs: {earlier}, listed on the page")
    for line in [*results(snapshot, report.made), f"everything on one page: {page.relative_to(home.root)}"]:
        console.print(escape(line), soft_wrap=True, highlight=False)


def _duration(seconds: float) -> str:
    seconds = round(seconds)
    return f"{seconds // 60} min {seconds % 60} s" if seconds >= 60 else f"{seconds} s"
