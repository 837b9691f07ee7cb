"""What the video discriminator is worth on demonstrations and garments that it has not seen.

`python -m benchmarks.discriminator GARMENT... [--folds 4] [--steps 400] [--frames 12] [--width 64] [--height 48] [--processes 2] [--out FILE]`
reads what the store holds of `seed_demos` and `candidate_trajectories`. Each garment's demonstrations are dealt out to folds, clips go with them;
in turn one fold tests, the next sets the thresholds, the others train, so that every clip is tested once by a network that saw
nothing of its demonstrations. Rules are learned from all but the fold that tests. With several garments, each is tested besides by a network that
learned from the others alone; rules measure a garment by its own keypoints and do not carry over.
Each row is told once more for the clips that are clear: whose worst figure lies at least a tenth of its limit from the judge's line.
"""

import json
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from assets_defs._store import verified
from benchmarks.discriminator.episodes import NEEDED, drawn, judged
from benchmarks.discriminator.figures import accepted_by_class, figures_of, told
from benchmarks.discriminator.turns import RECALL, Tested, among, pooled, run_turn, turn_by_garment, turns_by_fold
from pipeline import Home, load_graph
from sim1.validity.stage import VideoDiscriminatorConfig
from sim1.validity.success import OUT_OF_VIEW

CLEAR = 0.1  # of the limit of a fold's worst figure: farther from the judge's line a person needs no ruler either
type Verdicts = dict[str, tuple[str | None, float]]


def main(
    garments: list[str],
    folds: Annotated[int, typer.Option(min=3)] = 4,
    steps: int = 400,
    frames: int = 12,
    width: int = 64,
    height: int = 48,
    processes: int = 2,
    out: Path = Path("build/discriminator.json"),
) -> None:
    """Print rows for each garment, and write the figures."""
    home = Home.here()
    config = VideoDiscriminatorConfig(step_count=steps, frame_count=frames, frame_width=width, frame_height=height)
    graph, clips, features, verdicts = load_graph(home), {}, {}, {}
    for garment in garments:
        paths = {name: verified(home, graph.nodes[name], garment)[0] for name in NEEDED}
        verdicts[garment] = judged(paths["seed_demos"], paths["candidate_trajectories"])
        clips[garment], features[garment] = drawn(paths, config)
    kinds = {(name, "other demonstrations"): turns_by_fold(name, some, folds) for name, some in clips.items()}
    if len(clips) > 1:
        kinds |= {(name, "other garments"): ([turn_by_garment(name, clips)], 0) for name in clips}
    titles = ("tested on", "clips", "area under ROC", f"precision; recall, {config.precision:.0%} wanted", f"{RECALL:.0%} kept", "rules alone", "both")  # fmt: skip
    table, found = Table(*titles), {}
    with ProcessPoolExecutor(processes) as pool:
        asked = {
            (garment, other): [
                pool.submit(
                    run_turn,
                    turn,
                    config,
                    features[garment] if other == "other demonstrations" else None,
                    {name for name, (failure, _) in verdicts[garment].items() if failure == OUT_OF_VIEW},
                )
                for turn in turns
            ]
            for (garment, other), (turns, _) in kinds.items()
        }
        for (garment, other), futures in asked.items():
            tested, key = pooled([future.result() for future in futures]), f"{garment}, {other}"
            found[key] = told_apart(tested, verdicts[garment]) | {"left_out": kinds[garment, other][1]}
            table.add_row(key, *_cells(found[key]))
            table.add_row("  the clear ones", *_cells(found[key]["clear"]))
            for name, (accepted, of) in found[key]["accepted_by_class"].items():
                table.add_row(f"  {name}", "", "", "", f"{accepted} of {of} accepted")
    Console(width=260).print(table)
    settings = {name: getattr(config, name) for name in ("step_count", "frame_count", "frame_width", "frame_height")}
    about = {"schema": "sim1.discriminator_benchmark/3", "settings": settings | {"folds": folds, "garments": garments}}
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(json.dumps(about | {"found": found}, indent=1) + "\n")


def told_apart(tested: Tested, verdicts: Verdicts) -> dict[str, Any]:
    """Figures of all clips, of the clear ones, and of each class of failure."""
    clear = {name for name, (_, excess) in verdicts.items() if abs(excess) >= CLEAR}
    classes = accepted_by_class(tested, verdicts)
    return figures_of(tested) | {"clear": figures_of(among(tested, clear)), "accepted_by_class": classes}


def _cells(made: dict[str, Any]) -> list[str]:
    count = f"{made['success_count']} + {made['failure_count']}"
    areas = ", ".join(f"{area:.3f}" for area in made["roc_area"])
    return [count, areas, *(told(made[kind]) for kind in ("precise", "generous", "rules", "both"))]


if __name__ == "__main__":
    typer.run(main)
