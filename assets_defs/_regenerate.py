"""Make everything that is not fresh: the loop behind `sim1 run` and the nightly schedule."""

import os
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import wait
from pathlib import Path
from typing import Protocol

import dagster as dg

from assets_defs._digest import digest_json
from assets_defs._factory import GARMENTS
from assets_defs._recipe import Key, Snapshot, label
from assets_defs._store import alone as _alone
from assets_defs._store import place
from assets_defs._worker import PID_TAG, Inline, Outcome, Progress, Worker
from pipeline import Graph, Home, Node

UNKNOWN_SECONDS = 20.0  # guess for what was never made; only the time left depends on it


@dataclass
class Report:
    """What a regeneration did."""

    made: dict[str, float] = field(default_factory=dict)  # label -> seconds
    failed: dict[str, str] = field(default_factory=dict)  # label -> message
    waiting: dict[str, str] = field(default_factory=dict)  # label -> what it waits for
    fresh: int = 0


class Observer(Protocol):
    """Who watches a regeneration."""

    def plan(self, seconds_left: float, count_left: int) -> None: ...
    def started(self, name: str) -> None: ...
    def progress(self, name: str, done: float, total: float, what: str) -> None: ...
    def finished(self, name: str, seconds: float, message: str) -> None: ...


class _Log:
    """Observer that writes a line per artifact."""

    def __init__(self, notify: Callable[[str], None]):
        self._notify = notify

    def plan(self, seconds_left: float, count_left: int) -> None:
        pass

    def started(self, name: str) -> None:
        self._notify(f"{name}: started")

    def progress(self, name: str, done: float, total: float, what: str) -> None:
        pass

    def finished(self, name: str, seconds: float, message: str) -> None:
        self._notify(f"{name}: {message or 'made'} ({seconds:.1f} s)")


def regenerate(
    home: Home,
    graph: Graph,
    instance: dg.DagsterInstance,
    *,
    nodes: Iterable[str] | None = None,
    garments: Iterable[str] | None = None,
    jobs: int = 2,
    remember: bool = False,
    observer: Observer | None = None,
    notify: Callable[[str], None] = lambda line: None,
) -> Report:
    """Make every artifact that is stale or missing, parents first, until nothing is left to do.

    Args:
        nodes: only these nodes. None: all.
        garments: only these garments' artifacts (joint ones too). None: all.
        jobs: worker processes; 0 works in this process.
        remember: make the graph's profile that of later commands.

    Raises:
        StoreError: another regeneration is under way.
    """
    with _alone(home):
        if remember:
            home.remember_profile(graph.profile)
        _bury_dead_runs(instance)
        sync_garments(home, instance)
        chosen = set(nodes) if nodes is not None else set(graph.nodes)
        only = set(garments) if garments is not None else None
        loop = _Loop(home, graph, instance, chosen, only, observer or _Log(notify), jobs)
        try:
            return loop.run()
        finally:
            loop.stop()


class _Loop:
    def __init__(self, home, graph, instance, chosen, only, observer: Observer, jobs: int):
        self.home, self.graph, self.instance, self.observer = home, graph, instance, observer
        self.snapshot = Snapshot(instance, graph, home)
        self.tasks = [
            (node, key)
            for node, key in self.snapshot.artifacts()
            if node.id in chosen and (key is None or only is None or key in only)
        ]
        self.jobs = max(1, jobs)
        self.workers: list[Worker | Inline] = [] if jobs else [Inline(home, graph, instance)]
        self.tried: set[tuple[str, Key, str]] = set()
        self.began: dict[tuple[str, Key], float] = {}
        self.report = Report()

    def run(self) -> Report:
        while True:
            ready = self._ready()
            self._plan()
            for node, key in ready:
                if self._busy() >= self.jobs:
                    break
                if not self._pool_is_taken(node):
                    self._begin(node, key)
            if not self._busy():
                break
            self._listen()
        self._count_rest()
        return self.report

    def _ready(self) -> list[tuple[Node, Key]]:
        found = []
        running = set(self.began)
        for node, key in self.tasks:
            if (node.id, key) in running or self.snapshot.status(node, key).state not in ("stale", "missing", "failed"):
                continue
            parents = list(self.snapshot.parents(node, key))
            if any(self.snapshot.status(parent, at).state != "fresh" for _, parent, at in parents):
                continue
            if any((parent.id, at) in running for _, parent, at in parents):
                continue
            if (node.id, key, self._recipe(node, key)) not in self.tried:
                found.append((node, key))
        return found

    def _recipe(self, node: Node, key: Key) -> str:
        return digest_json(self.snapshot.parts(node, key))

    def _busy(self) -> int:
        return len(self.began)

    def _pool_is_taken(self, node: Node) -> bool:
        pools = {self.graph.nodes[id_].stage.pool for id_, _ in self.began}
        return node.stage.pool is not None and node.stage.pool in pools

    def _begin(self, node: Node, key: Key) -> None:
        worker = next((worker for worker in self.workers if worker.task is None and worker.alive), None)
        if worker is None:
            worker = Worker(self.home.root, self.graph.profile)
            self.workers.append(worker)
        self.tried.add((node.id, key, self._recipe(node, key)))
        self.began[node.id, key] = time.monotonic()
        self.observer.started(label(node, key))
        with suppress(BrokenPipeError):  # a worker that died is heard of in _listen
            worker.begin(node.id, key)

    def _listen(self) -> None:
        busy = {worker.pipe: worker for worker in self.workers if worker.task is not None}
        for pipe in list(busy) if None in busy else wait(list(busy), timeout=1.0):
            worker = busy[pipe]
            node, key = self.graph.nodes[worker.task[0]], worker.task[1]
            match worker.answer():
                case Progress(done, total, what):
                    self.observer.progress(label(node, key), done, total, what)
                case Outcome(ok, message):
                    self._finish(worker, node, key, "" if ok else message)

    def _finish(self, worker: Worker, node: Node, key: Key, message: str) -> None:
        seconds = time.monotonic() - self.began.pop((node.id, key))
        worker.task = None
        if not worker.alive:
            self.workers.remove(worker)
            _bury_dead_runs(self.instance)
        name, message = label(node, key), self.home.relative(message)
        if message:
            self.report.failed[name] = message
        else:
            self.report.made[name] = seconds
            self.report.failed.pop(name, None)
        self.snapshot.refresh(self.instance, node.id)
        self.observer.finished(name, seconds, message)

    def _plan(self) -> None:
        left, seconds = 0, 0.0
        now = time.monotonic()
        for node, key in self.tasks:
            if self.snapshot.status(node, key).state in ("fresh", "failed") and (node.id, key) not in self.began:
                continue
            left += 1
            record = place(self.home, node, key).record()
            expected = record["seconds"] if record else UNKNOWN_SECONDS
            seconds += max(0.0, expected - (now - self.began.get((node.id, key), now)))
        self.observer.plan(seconds / self.jobs, left)

    def _count_rest(self) -> None:
        for node, key in self.tasks:
            status, name = self.snapshot.status(node, key), label(node, key)
            if status.state == "fresh":
                self.report.fresh += name not in self.report.made
            elif name not in self.report.failed:
                self.report.waiting[name] = status.why

    def stop(self) -> None:
        for worker in self.workers:
            worker.stop()
        if self.began:
            _bury_dead_runs(self.instance)


def sync_garments(home: Home, instance: dg.DagsterInstance) -> None:
    """Make the partitions equal to the files in `data/garments/`."""
    files, known = set(home.garments()), set(instance.get_dynamic_partitions(GARMENTS.name))
    if files - known:
        instance.add_dynamic_partitions(GARMENTS.name, sorted(files - known))
    for gone in sorted(known - files):
        instance.delete_dynamic_partition(GARMENTS.name, gone)


def _bury_dead_runs(instance: dg.DagsterInstance) -> None:
    """Close runs whose process is gone, so that they hold neither a pool's slot nor the automation back."""
    unfinished = dg.RunsFilter(statuses=[dg.DagsterRunStatus.STARTED, dg.DagsterRunStatus.STARTING])
    for run in instance.get_runs(unfinished):
        pid = run.tags.get(PID_TAG)
        if pid and not _alive(int(pid)):
            instance.report_run_failed(run, "its process is gone")
            if instance.event_log_storage.supports_global_concurrency_limits:
                instance.event_log_storage.free_concurrency_slots_for_run(run.run_id)


def _alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    stat = Path(f"/proc/{pid}/stat")  # a dead child that nobody has asked for still answers signals
    return not (stat.exists() and stat.read_text().rpartition(")")[2].split()[0] == "Z")
