"""The work of stage motion_likeness: plan paths, compare them with the demonstrations, record."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import torch
from threadpoolctl import threadpool_limits

from sim1.motion.commands import Arms
from sim1.motion.home import read_home
from sim1.motion.likeness.classifier import FOLDS, TREES
from sim1.motion.likeness.comparison import COPY_MINIMUM, SET_MINIMUM, Figure, Paths, chance, compare, of_paths, telling
from sim1.motion.likeness.copies import COPY_SHARE
from sim1.motion.likeness.families import FAMILY_MINIMUM
from sim1.motion.likeness.features import FEATURES
from sim1.motion.likeness.joins import COMMON_SHARE
from sim1.motion.likeness.limits import in_words, verdicts
from sim1.motion.likeness.page import write_page
from sim1.motion.likeness.paths import Planned, by_method, demonstrated, make_plans, planned_paths
from sim1.motion.likeness.picture import draw_likeness
from sim1.motion.likeness.smoothness import PEAK_PROMINENCE, SPARC_CUT_OFF_HZ, SPARC_PADDING, SPARC_THRESHOLD
from sim1.motion.model import read_model
from sim1.motion.pool import read_pool
from sim1.scene.description import read_scene
from sim1.stage import BadInput, Facts, Inputs, only, random_stream

if TYPE_CHECKING:
    from sim1.motion.stage import MotionLikenessConfig

SCHEMA = "sim1.likeness/1"
TELLING = 6  # features that give a method away most, on the page
SETTINGS = {
    "sparc_cut_off_hz": SPARC_CUT_OFF_HZ, "sparc_threshold": SPARC_THRESHOLD, "sparc_padding": SPARC_PADDING,
    "peak_prominence": PEAK_PROMINENCE, "common_share": COMMON_SHARE, "copy_share": COPY_SHARE,
    "set_minimum": SET_MINIMUM, "family_minimum": FAMILY_MINIMUM, "copy_minimum": COPY_MINIMUM, "folds": FOLDS, "trees": TREES,
    "features": list(FEATURES),
}  # fmt: skip


def measure(inputs: Inputs, garment: str, config: MotionLikenessConfig, out: Path) -> Facts:
    """Plan, compare and write everything that the stage makes.

    Raises:
        BadInput: no draw gave a path by the model.
    """
    torch.set_num_threads(1)
    segments, model = read_pool(only(inputs, "segment_pool")), read_model(only(inputs, "motion_model"))
    home, arms = read_home(only(inputs, "seed_demos")), Arms.of_scene(read_scene(only(inputs, "scene")))
    methods, demos = by_method(model), demonstrated(segments)
    made = make_plans(methods, segments, home, arms, garment, config, moved=False)
    moved = make_plans(methods, segments, home, arms, garment, config, moved=True)
    if not made[model.method].plans:
        reasons = sorted({item.failure for item in made[model.method].refused})
        raise BadInput(
            f"{only(inputs, 'segment_pool')}: no path could be planned ({', '.join(reasons)}); make more seed_demos"
        )
    paths = {name: planned_paths(item.plans) for name, item in made.items() if item.plans}
    with threadpool_limits(1):
        figures = _figures(demos, paths, garment, config)
    record = {
        "schema": SCHEMA, "garment": garment, "seed": config.seed, "method": model.method, "settings": SETTINGS,
        "stand_in": "the demonstrator is a scripted expert in place of a person who teleoperates, but for garments with commands in data/demonstrations/",
        "counts": _counts(demos, made, moved),
        "figures": {name: _records(row) for name, row in figures.items()},
        "moved_figures": {
            name: _records(of_paths(demos, planned_paths(item.plans))) for name, item in moved.items() if item.plans
        },
        "telling": {name: telling(demos, others, TELLING) for name, others in paths.items()},
        "limits": {name: verdicts(row) for name, row in figures.items() if name != "demonstrations"},
    }  # fmt: skip
    (out / "likeness.json").write_text(json.dumps(record, indent=1, sort_keys=True, allow_nan=False) + "\n")
    draw_likeness(out / "likeness.png", demos, paths)
    write_page(out, record)
    return _facts(record)


def _figures(
    demos: Paths, paths: dict[str, Paths], garment: str, config: MotionLikenessConfig
) -> dict[str, dict[str, Figure]]:
    def stream(name: str) -> Any:
        return random_stream(config.seed, garment, "likeness of", name)

    count = config.permutation_count
    own = {"demonstrations": chance(demos, config.split_count, stream("demonstrations"))}
    return own | {name: compare(demos, others, count, stream(name)) for name, others in paths.items()}


def _counts(demos: Paths, made: dict[str, Planned], moved: dict[str, Planned]) -> dict[str, Any]:
    return {
        "demonstrations": len(demos.tools),
        "demonstrated_transitions": len(demos.movements),
        "plans": {name: item.counts() for name, item in made.items()},
        "moved_plans": {name: item.counts() for name, item in moved.items()},
    }


def _records(figures: dict[str, Figure]) -> dict[str, Any]:
    return {name: figure.record() for name, figure in figures.items()}


def _facts(record: dict[str, Any]) -> Facts:
    method, counts = record["method"], record["counts"]
    limits = record["limits"][method]
    return {
        "method": method,
        "demonstration_count": counts["demonstrations"],
        "plan_count": counts["plans"][method]["planned"],
        "limits_met": f"{sum(row['met'] is True for row in limits)} of {len(limits)}",
        **{row["figure"]: in_words(row) for row in limits},
        "stand_in": record["stand_in"],
    }
