"""Where the time of an attempt goes, and what more processes bring: `python -m benchmarks.generation towel tshirt --attempts 8`.

Needs the garments' artifacts in the store (`make run`). Shares of processor time, and a ratio of wall times within one run.
"""

import argparse
import functools
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from assets_defs._config import config_of
from assets_defs._generate import given
from pipeline import Home, load_graph

ATTEMPTS = 3
WORKERS = (1, 2)
OTHER_SEED = 1  # more than the stage's own, whose attempts its filters know


class Clock:
    """Processor seconds spent inside functions that it wraps."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    def around(self, name: str, do: Callable[..., Any]) -> Callable[..., Any]:
        """The same function, timed."""

        @functools.wraps(do)
        def timed(*given: Any, **named: Any) -> Any:
            began = time.process_time()
            try:
                return do(*given, **named)
            finally:
                self.seconds[name] = self.seconds.get(name, 0.0) + time.process_time() - began

        return timed


def steps_of(inputs: Any, garment: str, config: Any) -> tuple[dict[str, float], float, int]:
    """Processor seconds of each step over some attempts, all of them together, and how many ran."""
    import sim1.motion.bench as bench_module
    import sim1.motion.joining as joining
    from sim1.motion.bench import Bench
    from sim1.motion.commands import Arms
    from sim1.quota import Ticket

    bench, clock = Bench.of(inputs, garment, config), Clock()
    wrapped = [
        (bench.cell, "step", "simulation"),
        (Arms, "joints_for", "inverse kinematics"),
        (joining, "transition", "diffusion"),
        (bench_module, "judge", "judge"),
        (bench_module, "head_clip", "video"),
    ]
    kept = [(owner, name, getattr(owner, name)) for owner, name, _ in wrapped]
    for owner, name, label in wrapped:
        setattr(owner, name, clock.around(label, getattr(owner, name)))
    try:
        began, ran = time.process_time(), 0
        for number in range(ATTEMPTS):
            with tempfile.TemporaryDirectory() as folder:
                ran += bench.make(Ticket(series="", number=number), Path(folder))["ran"]
        whole = time.process_time() - began
    finally:
        for owner, name, before in kept:
            setattr(owner, name, before)
    return clock.seconds | {"all else": whole - sum(clock.seconds.values())}, whole, ran


def growth_of(inputs: Any, garment: str, config: Any, count: int) -> dict[int, float]:
    """Attempts per hour of wall time by number of processes, what it takes to start them included once: of `count` attempts."""
    from sim1.crew import labour_together
    from sim1.motion.bench import Bench
    from sim1.quota import Quota

    quota = Quota(series="", run_count=0, target=count, counted="made", run_limit=count, try_limit=count)
    rates = {}
    for workers in WORKERS:
        with tempfile.TemporaryDirectory() as folder:
            began = time.perf_counter()
            labour_together(
                Path(folder),
                [quota],
                functools.partial(_Counted.of, Bench, inputs, garment, config),
                workers,
                lambda rows: None,
            )
            rates[workers] = 3600 * count / (time.perf_counter() - began)
    return rates


class _Counted:
    """A maker whose every attempt counts."""

    def __init__(self, bench: Any) -> None:
        self.bench = bench

    @classmethod
    def of(cls, kind: Any, *given: Any) -> "_Counted":
        return cls(kind.of(*given))

    def make(self, ticket: Any, folder: Path) -> dict[str, Any]:
        return self.bench.make(ticket, folder) | {"ran": True, "made": True}


def main(garments: list[str], attempts: int) -> None:
    """Print one table for each garment; `attempts` by one process, and again by two."""
    console, home = Console(), Home.here()
    graph = load_graph(home)
    for garment in garments:
        config = config_of(graph.nodes["candidate_trajectories"])
        other = config.seed + OTHER_SEED
        inputs, _, _ = given(home, graph, garment, None, other)
        config = config.model_copy(update={"seed": other})
        seconds, whole, ran = steps_of(inputs, garment, config)
        table = Table("step", "processor s an attempt", "share", title=f"{garment}: {ATTEMPTS} attempts, {ran} ran")
        for name, value in sorted(seconds.items(), key=lambda item: -item[1]):
            table.add_row(name, f"{value / ATTEMPTS:.2f}", f"{100 * value / whole:.0f} %")
        console.print(table)
        rates = growth_of(inputs, garment, config, attempts)
        first = rates[WORKERS[0]]
        for workers, rate in rates.items():
            console.print(f"{attempts} by {workers}: {rate:.0f} attempts an hour, {rate / first:.2f} times one process")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("garments", nargs="*", default=["towel"])
    parser.add_argument("--attempts", type=int, default=8)
    given_by_user = parser.parse_args()
    main(given_by_user.garments, given_by_user.attempts)
