"""Timings as ratios within one run: `make bench`. Writes `benchmarks/results.json`; seconds depend on the machine, ratios less."""

import json
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks import frames, lineage, remeshing

BENCHMARKS = (lineage.compare, remeshing.compare, frames.compare)


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


if __name__ == "__main__":
    main()
