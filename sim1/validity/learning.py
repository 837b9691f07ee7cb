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

if TYPE_CHECKING:
    from sim1.validity.stage import StateRulesConfig

ABOUT = ("example", "success", "perturbed")


def learn(demos: Path, candidates: Path, mesh: GarmentMesh, config: StateRulesConfig, out: Path) -> Facts:
    """Features, rules, picture and record.

    Raises:
        BadInput: no example succeeded.
    """
    reference = reference_of(mesh, demos)
    rows = [
        {"example": item.name, "success": item.success, "perturbed": item.perturbed}
        | episode_features(item.episode.garment_m, reference)
        for item in read_examples(demos, candidates, "particle features")
    ]
    table = pd.DataFrame(rows)
    if table.empty or not table.success.any():
        raise BadInput(f"{demos}: no successful run among {len(table)}; record demonstrations that succeed")
    table.to_parquet(out / "features.parquet", index=False)
    features, success = table.drop(columns=list(ABOUT)), table.success.to_numpy(bool)
    write_rules(out / "rules.yaml", _learned(features, success, config))
    rules = read_rules(out / "rules.yaml")
    kept, left_out = admissible(rules, features), _left_out(features, success, config)
    record = {
        "recall_floor": config.recall_floor,
        "method": rules.method,
        "reason": rules.reason,
        "successes_admitted": describe_share(int(kept[success].sum()), int(success.sum())),
        "failures_rejected": describe_share(int((~kept[~success]).sum()), int((~success).sum())),
        "successes_admitted_left_out": describe_share(int(left_out[success].sum()), int(success.sum())),
        "failures_rejected_left_out": describe_share(int((~left_out[~success]).sum()), int((~success).sum())),
    }
    (out / "training.json").write_text(json.dumps(record, indent=1, sort_keys=True) + "\n")
    draw_rules(out / "rules.png", rules, table)
    return record | {"condition_count": sum(len(alternative) for alternative in rules.any_of)}


def _learned(features: pd.DataFrame, success: np.ndarray, config: StateRulesConfig) -> Rules:
    return learn_rules(
        features,
        success,
        depth=config.depth,
        recall_floor=config.recall_floor,
        margin=config.margin,
        minimum_per_class=config.minimum_per_class,
    )


def _left_out(features: pd.DataFrame, success: np.ndarray, config: StateRulesConfig) -> np.ndarray:
    """(n,) bool: whether rules learned from all other examples admit each one."""
    result = np.zeros(len(success), bool)
    for index in range(len(success)):
        others = np.arange(len(success)) != index
        if success[others].any():
            rules = _learned(features[others], success[others], config)
            result[index] = admissible(rules, features.iloc[[index]])[0]
    return result
