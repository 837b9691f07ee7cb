"""The work of stage state_rules: features of all examples, rules learned from them, and how well they generalise."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from sim1.cloth.garment import GarmentMesh
from sim1.stage import BadInput, Facts
from sim1.statistics import describe_share
from sim1.validity.examples import read_examples, reference_of
from sim1.validity.features import episode_features
from sim1.validity.pictures import draw_rules
from sim1.validity.rules import Rules, admissible, learn_rules, read_rules, write_rules
from sim1.validity.success import CUT_SHORT, OUT_OF_VIEW

if TYPE_CHECKING:
    from sim1.validity.stage import StateRulesConfig

ABOUT = ("example", "success", "perturbed")


def learn(demos: Path, candidates: Path, mesh: GarmentMesh, config: StateRulesConfig, out: Path) -> Facts:
    """Features, rules, picture and record.

    Raises:
        BadInput: no example succeeded.
    """
    reference = reference_of(mesh, demos)
    rows, sources = [], []
    # Features do not say where a garment lay: what is out of view would be folded garments called failures.
    for item in read_examples(demos, candidates, "particle features", without=CUT_SHORT | {OUT_OF_VIEW}):
        about = {"example": item.name, "success": item.success, "perturbed": item.perturbed}
        rows.append(about | episode_features(item.episode.garment_m, reference))
        sources.append(item.sources)
    table = pd.DataFrame(rows)
    if table.empty or not table.success.any():
        raise BadInput(f"{demos}: no successful run among {len(table)}; record demonstrations that succeed")
    table.to_parquet(out / "features.parquet", index=False)
    features, success = table.drop(columns=list(ABOUT)), table.success.to_numpy(bool)
    write_rules(out / "rules.yaml", learned(features, success, config))
    rules = read_rules(out / "rules.yaml")
    kept = admissible(rules, features)
    judged, admitted = _left_out(features, success, sources, config)
    record = {
        "recall_floor": config.recall_floor,
        "method": rules.method,
        "reason": rules.reason,
        "successes_admitted": describe_share(int(kept[success].sum()), int(success.sum())),
        "failures_rejected": describe_share(int((~kept[~success]).sum()), int((~success).sum())),
        "successes_admitted_left_out": describe_share(int(admitted[success].sum()), int(judged[success].sum())),
        "failures_rejected_left_out": describe_share(
            int((judged & ~admitted)[~success].sum()), int(judged[~success].sum())
        ),
        "not_judged_left_out": int((~judged).sum()),
    }
    (out / "training.json").write_text(json.dumps(record, indent=1, sort_keys=True) + "\n")
    draw_rules(out / "rules.png", rules, table)
    return record | {"condition_count": sum(len(alternative) for alternative in rules.any_of)}


def learned(features: pd.DataFrame, success: np.ndarray, config: StateRulesConfig) -> Rules:
    """Rules from examples (n, features) with their outcome (n,) bool, as the stage learns them.

    Raises:
        ValueError: there is no successful example.
    """
    return learn_rules(
        features,
        success,
        depth=config.depth,
        recall_floor=config.recall_floor,
        margin=config.margin,
        minimum_per_class=config.minimum_per_class,
    )


def _left_out(
    features: pd.DataFrame, success: np.ndarray, sources: list[frozenset[str]], config: StateRulesConfig
) -> tuple[np.ndarray, np.ndarray]:
    """Whether rules could be learned from the examples that share no demonstration with each one, and whether they admit it.

    Generated motion repeats the demonstrations that it is made of: rules that saw one of its kin know it already.

    Returns:
        (n,) bool, False where no other example succeeded; (n,) bool.
    """
    judged, admitted = np.zeros(len(success), bool), np.zeros(len(success), bool)
    for left_out in set(sources):
        others = np.array([left_out.isdisjoint(some) for some in sources])
        if success[others].any():
            here = np.array([some == left_out for some in sources])
            judged |= here
            admitted[here] = admissible(learned(features[others], success[others], config), features[here])
    return judged, admitted
