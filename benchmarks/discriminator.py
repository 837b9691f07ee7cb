"""What the video discriminator is worth on demonstrations and garments that it has not seen.

`python -m benchmarks.discriminator GARMENT... [--folds 4] [--steps 400] [--frames 12] [--processes 2] [--out FILE]` reads what the
store holds of `seed_demos` and `candidate_trajectories`. Each garment's demonstrations are dealt out to folds, clips go with them;
in turn one fold tests, the next sets the thresholds, the others train, so that every clip is tested once by a network that saw
nothing of its demonstrations. With several garments, each is tested besides by a network that learned from the others alone.
"""

import json
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from assets_defs._store import verified
from pipeline import Home, load_graph
from sim1.clustered_share import clustered_interval, counts_by_cluster
from sim1.motion.likeness.classifier import area_under_roc
from sim1.motion.likeness.families import families
from sim1.stage import BadInput, random_stream
from sim1.statistics import describe_share
from sim1.validity.evidence import threshold_for
from sim1.validity.parts import LabelledClip, deal
from sim1.validity.stage import VideoDiscriminatorConfig

NEEDED = ("seed_demos", "candidate_trajectories", "garment_mesh", "scene")
RECALL = 0.8  # of the calibration clips, by which the second threshold is chosen


@dataclass(frozen=True, kw_only=True)
class Turn:
    """One network: what it learns from, what sets its thresholds, what tests it."""

    name: str
    train: list[LabelledClip]
    calibration: list[LabelledClip]
    test: list[LabelledClip]


@dataclass(frozen=True, kw_only=True)
class Tested:
    """Clips that had no say in network and thresholds."""

    success: np.ndarray  # (n,) bool
    family: np.ndarray  # (n,) names: clips of one family hang together
    precise: np.ndarray  # (n,) bool, accepted at the threshold of the wanted precision
    generous: np.ndarray  # (n,) bool, accepted at the threshold that keeps `RECALL` of the calibration's successes
    roc_area: tuple[float, ...]  # of each network


def turns_by_fold(garment: str, clips: Sequence[LabelledClip], count: int) -> tuple[list[Turn], int]:
    """Every fold tests once; the second part is how many clips mix demonstrations of several folds and are in none."""
    dealt, left_out = deal(clips, dict.fromkeys(range(count), 1 / count))
    turns = []
    for fold, test in dealt.items():
        judge = (fold + 1) % count
        train = [clip for other, some in dealt.items() if other not in (fold, judge) for clip in some]
        turns.append(Turn(name=f"{garment}, fold {fold}", train=train, calibration=dealt[judge], test=test))
    return turns, len(left_out)


def turn_by_garment(garment: str, clips: dict[str, list[LabelledClip]]) -> Turn:
    """The garment tests what was learned from the others; a fifth of their demonstrations sets the thresholds."""
    others = [clip for name, some in clips.items() if name != garment for clip in some]
    dealt, _ = deal(others, {"train": 0.8, "calibration": 0.2})
    return Turn(name=f"{garment} from the others", **dealt, test=clips[garment])


def run_turn(turn: Turn, config: VideoDiscriminatorConfig) -> Tested:
    """Train, choose both thresholds, test.

    Raises:
        BadInput: clips that train, set thresholds or test are all of one outcome.
    """
    import torch

    from sim1.validity.scoring import scores, train_discriminator

    for part in ("train", "calibration", "test"):
        some = _successes(getattr(turn, part))
        if some.all() or not some.any():
            raise BadInput(
                f"{turn.name}: {some.sum()} of {len(some)} clips of the part {part} are successes, expected some of both; "
                "give fewer folds or more attempts"
            )
    torch.set_num_threads(1)
    network, _ = train_discriminator(
        turn.train,
        width=config.width,
        layer_count=config.layer_count,
        step_count=config.step_count,
        batch_size=config.batch_size,
        learning_rate=config.learning_rate,
        rng=random_stream(config.seed, turn.name),
    )
    score, success = (_column(network, scores, turn.calibration), _successes(turn.calibration))
    precise = threshold_for(score, success, config.precision)
    generous = np.quantile(score[success], 1 - RECALL, method="lower")
    tested, good = _column(network, scores, turn.test), _successes(turn.test)
    kin = families([clip.sources for clip in turn.test])
    return Tested(
        success=good,
        family=np.array([f"{turn.name}/{number}" for number in kin]),
        precise=np.zeros(len(good), bool) if precise is None else tested >= precise,
        generous=tested >= generous,
        roc_area=(area_under_roc(good, tested),),
    )


def _column(network: Any, scores: Any, clips: Sequence[LabelledClip]) -> np.ndarray:
    return scores(network, [clip.frames for clip in clips])


def _successes(clips: Sequence[LabelledClip]) -> np.ndarray:
    return np.array([clip.success for clip in clips], bool)


def pooled(tested: Sequence[Tested]) -> Tested:
    """All together; networks differ, so that their scores are not put together but what each accepted is."""
    columns = {name: np.concatenate([getattr(one, name) for one in tested]) for name in ("success", "family", "precise", "generous")}  # fmt: skip
    return Tested(**columns, roc_area=tuple(area for one in tested for area in one.roc_area))


def figures_of(tested: Tested) -> dict[str, Any]:
    """Counts, ROC areas, and precision and recall at both thresholds, with intervals over families."""
    found: dict[str, Any] = {
        "success_count": int(tested.success.sum()),
        "failure_count": int((~tested.success).sum()),
        "roc_area": [round(area, 4) for area in tested.roc_area],
    }
    for name in ("precise", "generous"):
        taken = getattr(tested, name)
        found[name] = {
            "precision": _share(tested.success[taken], tested.family[taken]),
            "recall": _share(taken[tested.success], tested.family[tested.success]),
        }
    return found


def _share(wins: np.ndarray, family: np.ndarray) -> dict[str, Any]:
    if not len(wins):
        return {"count": 0, "of": 0, "ci95": [0.0, 1.0]}
    return {
        "count": int(wins.sum()),
        "of": len(wins),
        "ci95": list(clustered_interval(*counts_by_cluster(wins, family))),
    }


def told(share: dict[str, Any]) -> str:
    """As a cell of a table."""
    return describe_share(share["count"], share["of"], tuple(share["ci95"]))


def main(
    garments: list[str],
    folds: Annotated[int, typer.Option(min=3)] = 4,
    steps: int = 400,
    frames: int = 12,
    processes: int = 2,
    out: Path = Path("build/discriminator.json"),
) -> None:
    """Print a row for each garment, and write the figures."""
    from sim1.cloth.garment import read_garment_mesh
    from sim1.scene.description import read_scene
    from sim1.validity.watching import labelled_clips

    home, config = Home.here(), VideoDiscriminatorConfig(step_count=steps, frame_count=frames)
    graph, clips = load_graph(home), {}
    for garment in garments:
        paths = {name: verified(home, graph.nodes[name], garment)[0] for name in NEEDED}
        clips[garment] = labelled_clips(
            paths["seed_demos"],
            paths["candidate_trajectories"],
            read_garment_mesh(paths["garment_mesh"]),
            read_scene(paths["scene"]),
            config,
        )
    rows: dict[str, tuple[list[Turn], int]] = {
        f"{name}, other demonstrations": turns_by_fold(name, some, folds) for name, some in clips.items()
    }
    if len(clips) > 1:
        rows |= {f"{name}, other garments": ([turn_by_garment(name, clips)], 0) for name in clips}
    table, found = Table("tested on", "clips", "area under ROC", f"precision, recall at {config.precision:.0%} wanted", f"at {RECALL:.0%} kept"), {}  # fmt: skip
    with ProcessPoolExecutor(processes) as pool:
        asked = {name: [pool.submit(partial(run_turn, turn, config)) for turn in turns] for name, (turns, _) in rows.items()}  # fmt: skip
        for name, futures in asked.items():
            made = figures_of(pooled([future.result() for future in futures]))
            found[name] = made | {"left_out": rows[name][1]}
            cells = [
                f"{told(made[kind]['precision'])}; {told(made[kind]['recall'])}" for kind in ("precise", "generous")
            ]
            count = f"{made['success_count']} + {made['failure_count']}"
            table.add_row(name, count, ", ".join(f"{area:.3f}" for area in made["roc_area"]), *cells)
    Console(width=200).print(table)
    out.parent.mkdir(parents=True, exist_ok=True)
    settings = {"folds": folds, "steps": steps, "frames": frames, "garments": garments}
    out.write_text(
        json.dumps({"schema": "sim1.discriminator_benchmark/1", "settings": settings, "found": found}, indent=1) + "\n"
    )


if __name__ == "__main__":
    typer.run(main)
