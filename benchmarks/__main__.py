"""Timings as ratios within one run: `make bench`. Writes `benchmarks/results.json`; seconds depend on the machine, ratios less.

The cloth solver beside others takes most of the time and writes files of its own: `benchmarks/solver/`.
"""

import json
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks import band_solving, frames, lineage, remeshing, rendering
from benchmarks.solver.__main__ import main as compare_solvers

BENCHMARKS = (
    lineage.compare,
    remeshing.compare,
    frames.compare,
    rendering.compare,
    rendering.compare_workers,
    band_solving.compare,
)


def main() -> None:
    """Run all comparisons, print a table, keep the ratios."""
    console = Console()
    table = Table("what", "against", "seconds", "seconds", "ratio")
    results = []
    for benchmark in BENCHMARKS:
        with console.status(benchmark.__module__):
            found = benchmark()
        results.append(found)
        table.add_row(
            found["what"], found["against"], *(f"{found[key]:.4g}" for key in ("seconds", "seconds_against", "ratio"))
        )
    console.print(table)
    out = Path(__file__).parent / "results.json"
    out.write_text(json.dumps({"schema": "sim1.benchmarks/1", "results": results}, indent=1) + "\n")
    console.print(f"written to {out.relative_to(Path.cwd())}")
    compare_solvers()


if __name__ == "__main__":
    main()
