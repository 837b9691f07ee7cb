"""What the video discriminator is worth on demonstrations and garments that it has not seen.

`python -m benchmarks.discriminator GARMENT... [--folds 4] [--steps 400] [--frames 12] [--width 64] [--height 48] [--processes 2] [--out FILE]`
reads what the store holds of `seed_demos` and `candidate_trajectories`. Each garment's demonstrations are dealt out to folds, clips go with them;
in turn one fold tests, the next sets the thresholds, the others train, so that every clip is tested once by a network that saw
nothing of its demonstrations. With several garments, each is tested besides by a network that learned from the others alone.
Each row is told once more for the clips that are clear: whose worst figure lies at least a fifth of its limit from the judge's line.
"""

import json
from collections.abc import Sequence, Set
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
from sim1.episode import episode_folders
from sim1.motion.likeness.classifier import area_under_roc
from sim1.motion.likeness.families import families
from sim1.robot.expert_task import read_task
from sim1.stage import BadInput, random_stream
from sim1.statistics import describe_share
from sim1.validity.evidence import threshold_for
from sim1.validity.examples import read_examples
from sim1.validity.parts import LabelledClip, deal
from sim1.validity.stage import VideoDiscriminatorConfig
from sim1.validity.success import fold_excess

NEEDED = ("seed_demos", "candidate_trajectories", "garment_mesh", "scene")
COLUMNS = ("name", "success", "family", "precise", "generous")  # of `Tested`, one entry a clip
CLEAR = 0.2  # of the limit of a fold's worst figure: farther from the judge's line a person needs no ruler either
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

    name: np.ndarray  # (n,) of the clips
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
        name=np.array([clip.name for clip in turn.test]),
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
    columns = {name: np.concatenate([getattr(one, name) for one in tested]) for name in COLUMNS}  # fmt: skip
    return Tested(**columns, roc_area=tuple(area for one in tested for area in one.roc_area))


def drawn(paths: dict[str, Path], config: VideoDiscriminatorConfig) -> list[LabelledClip]:
    """Clips of all demonstrations and candidates in the head view, drawn anew: of any number of frames of any size.

    Raises:
        BadInput: an episode is damaged.
    """
    from sim1.cloth.garment import read_garment_mesh
    from sim1.scene.description import read_scene
    from sim1.validity.clips import sampled
    from sim1.validity.raster import render_head_view

    faces, scene = read_garment_mesh(paths["garment_mesh"]).faces, read_scene(paths["scene"])
    clips = []
    for item in read_examples(paths["seed_demos"], paths["candidate_trajectories"], "clips"):
        shapes_m = sampled(item.episode.garment_m, config.frame_count)
        frames = [render_head_view(shape, faces, scene, config.frame_width, config.frame_height) for shape in shapes_m]
        clips.append(LabelledClip(name=item.name, frames=np.stack(frames), success=item.success, sources=item.sources))
    return clips


def among(tested: Tested, names: Set[str]) -> Tested:
    """The same of these clips alone; areas under curves of whole folds are none of theirs."""
    chosen = np.isin(tested.name, list(names))
    return Tested(**{name: getattr(tested, name)[chosen] for name in COLUMNS}, roc_area=())


def judged(demos: Path, candidates: Path) -> dict[str, tuple[str | None, float]]:
    """Of each clip by name: its class of failure, None where it folds, and how far its fold is beyond the judge's limits.

    Raises:
        BadInput: the task cannot be read.
    """
    limits, found = read_task(demos / "task.json").success, {}
    for kind, folder in (("demo", demos), ("candidate", candidates)):
        for episode in episode_folders(folder):
            about = json.loads((episode / "episode.json").read_text())
            figures = about["figures"]
            excess = fold_excess(figures, limits) if figures else np.inf  # no figures: the simulation broke
            found[f"{kind}/{episode.name}"] = (about["failure"], excess)
    return found


def accepted_by_class(tested: Tested, verdicts: dict[str, tuple[str | None, float]]) -> dict[str, tuple[int, int]]:
    """Of each class of failure, how many clips the generous threshold accepts, and of how many."""
    classes = np.array([verdicts[name][0] or "folded" for name in tested.name])
    return {
        str(one): (int(tested.generous[classes == one].sum()), int((classes == one).sum()))
        for one in sorted(set(classes))
    }


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
    width: int = 64,
    height: int = 48,
    processes: int = 2,
    out: Path = Path("build/discriminator.json"),
) -> None:
    """Print a row for each garment, and write the figures."""
    home = Home.here()
    config = VideoDiscriminatorConfig(step_count=steps, frame_count=frames, frame_width=width, frame_height=height)
    graph, clips, verdicts = load_graph(home), {}, {}
    for garment in garments:
        paths = {name: verified(home, graph.nodes[name], garment)[0] for name in NEEDED}
        verdicts[garment] = judged(paths["seed_demos"], paths["candidate_trajectories"])
        clips[garment] = drawn(paths, config)
    rows = {(name, "other demonstrations"): turns_by_fold(name, some, folds) for name, some in clips.items()}
    if len(clips) > 1:
        rows |= {(name, "other garments"): ([turn_by_garment(name, clips)], 0) for name in clips}
    table, found = Table("tested on", "clips", "area under ROC", f"precision, recall at {config.precision:.0%} wanted", f"at {RECALL:.0%} kept"), {}  # fmt: skip
    with ProcessPoolExecutor(processes) as pool:
        asked = {key: [pool.submit(partial(run_turn, turn, config)) for turn in turns] for key, (turns, _) in rows.items()}  # fmt: skip
        for (garment, learned_from), futures in asked.items():
            tested = pooled([future.result() for future in futures])
            clear = {name for name, (_, excess) in verdicts[garment].items() if abs(excess) >= CLEAR}
            whole, easy = figures_of(tested), figures_of(among(tested, clear))
            classes = accepted_by_class(tested, verdicts[garment])
            key = f"{garment}, {learned_from}"
            found[key] = whole | {
                "left_out": rows[garment, learned_from][1],
                "clear": easy,
                "accepted_by_class": classes,
            }
            table.add_row(key, *_cells(whole))
            table.add_row("  the clear ones", *_cells(easy))
            for name, (accepted, of) in classes.items():
                table.add_row(f"  {name}", "", "", "", f"{accepted} of {of} accepted")
    Console(width=200).print(table)
    out.parent.mkdir(parents=True, exist_ok=True)
    settings = {
        "folds": folds,
        "steps": steps,
        "frames": frames,
        "width": width,
        "height": height,
        "garments": garments,
    }
    out.write_text(
        json.dumps({"schema": "sim1.discriminator_benchmark/2", "settings": settings, "found": found}, indent=1) + "\n"
    )


def _cells(made: dict[str, Any]) -> list[str]:
    count = f"{made['success_count']} + {made['failure_count']}"
    shares = [f"{told(made[kind]['precision'])}; {told(made[kind]['recall'])}" for kind in ("precise", "generous")]
    return [count, ", ".join(f"{area:.3f}" for area in made["roc_area"]), *shares]


if __name__ == "__main__":
    typer.run(main)
