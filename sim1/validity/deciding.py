"""The work of stage valid_trajectories: judge, rules and discriminator applied to every candidate."""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd
import torch

from sim1.cloth.garment import read_garment_mesh
from sim1.episode import read_episode, read_start
from sim1.film_strip import HEIGHT, WIDTH
from sim1.progress import track
from sim1.scene.description import read_scene
from sim1.stage import BadInput, Facts, Inputs, only
from sim1.statistics import describe_share
from sim1.validity.clips import read_clip
from sim1.validity.examples import reference_of
from sim1.validity.features import Reference, episode_features
from sim1.validity.outcomes import draw_outcomes
from sim1.validity.pictures import draw_decisions
from sim1.validity.raster import render_head_view
from sim1.validity.rules import Rules, read_rules
from sim1.validity.success import CUT_SHORT
from sim1.validity.watching import Discriminator, read_discriminator

if TYPE_CHECKING:
    from sim1.validity.stage import ValidTrajectoriesConfig

VIDEO = "video.npz"


@dataclass(frozen=True, kw_only=True)
class Filters:
    """Everything that may reject a candidate."""

    rules: Rules
    discriminator: Discriminator
    reference: Reference
    config: ValidTrajectoriesConfig


def read_filters(inputs: Inputs, config: ValidTrajectoriesConfig) -> Filters:
    """The filters that were learned for a garment; raises BadInput."""
    return Filters(
        rules=read_rules(only(inputs, "state_rules") / "rules.yaml"),
        discriminator=read_discriminator(only(inputs, "video_discriminator")),
        reference=reference_of(read_garment_mesh(only(inputs, "garment_mesh")), only(inputs, "seed_demos")),
        config=config,
    )


def decide(inputs: Inputs, garment: str, config: ValidTrajectoriesConfig, out: Path) -> Facts:
    """Decide for every attempt, copy the accepted episodes, write and draw the decisions.

    Raises:
        BadInput: an input is damaged.
    """
    torch.set_num_threads(1)
    candidates = only(inputs, "candidate_trajectories")
    filters = read_filters(inputs, config)
    try:
        attempts = pd.read_parquet(candidates / "attempts.parquet")
    except (OSError, ValueError) as error:
        raise BadInput(
            f"{candidates}/attempts.parquet: not readable ({error}); make candidate_trajectories again"
        ) from error
    rows = []
    for attempt in track(attempts.to_dict("records"), "deciding"):
        folder = candidates / "episodes" / attempt["episode"]
        rows.append({"garment": garment, **decision(attempt, folder, filters)})
        if rows[-1]["accepted"]:
            _copy(folder, out / "episodes" / attempt["episode"])
    table = pd.DataFrame(rows).astype({"video_score": float})
    table.to_parquet(out / "decisions.parquet", index=False)
    (out / "limits.json").write_text(json.dumps({"minimum_accepted": config.minimum_accepted}) + "\n")
    draw_decisions(out / "decisions.png", rows, filters.discriminator.abstains or not config.use_video)
    faces, scene = read_garment_mesh(only(inputs, "garment_mesh")).faces, read_scene(only(inputs, "scene"))
    draw_outcomes(
        out / "film_strips.png",
        garment,
        rows,
        candidates / "episodes",
        read_start(only(inputs, "seed_demos")),
        lambda garment_m: render_head_view(garment_m, faces, scene, width=WIDTH, height=HEIGHT),
    )
    return _facts(table, filters)


def decision(attempt: dict[str, Any], folder: Path, filters: Filters) -> dict[str, Any]:
    """One row of the decisions: what each filter says of an attempt, and why it was rejected; raises BadInput."""
    config, reasons, broken, score = filters.config, [], [], None
    ran = bool(attempt["ran"])
    if ran:
        episode = read_episode(folder)
        broken = filters.rules.broken(episode_features(episode.garment_m, filters.reference))
        score = filters.discriminator.score(read_clip(folder), str(folder))
    else:
        reasons.append(f"did not run: {attempt['failure']}")
    video_passes = score is not None and score >= filters.discriminator.threshold
    if config.require_success and not attempt["success"]:
        reasons.append(f"judge: {attempt['failure']}")
    if config.use_rules and broken:
        reasons.append(f"rules: {broken[0]}" + (f" and {len(broken) - 1} more" if len(broken) > 1 else ""))
    if config.use_video and not filters.discriminator.abstains and ran and not video_passes:
        reasons.append(f"video: score {score:.4f} below {filters.discriminator.threshold:.4f}")
    return {
        "attempt": int(attempt["attempt"]),
        "episode": attempt["episode"],
        "perturbed": bool(attempt["perturbed"]),
        "ran": ran,
        "success": bool(attempt["success"]),
        "failure": attempt["failure"],
        "rules_pass": ran and not broken,
        "rules_broken": "; ".join(broken),
        "video_score": score,
        "video_pass": video_passes,
        "video_abstains": filters.discriminator.abstains,
        "accepted": not reasons,
        "reasons": "; ".join(reasons),
    }


def compared_filters(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """State rules alone, video alone and both, against the judge, over the attempts that ran to their end: one row each.

    On attempts that the filters learned from, as the stage's are, this flatters them. Precision: of what is admitted, the share that did the task. Recall: of what did the task, the share that is admitted.
    """
    ran = [row for row in rows if row["ran"] and row["failure"] not in CUT_SHORT]
    passes = {"state rules alone": [row["rules_pass"] for row in ran]}
    if ran and not ran[0]["video_abstains"]:
        video = [row["video_pass"] for row in ran]
        both = [one and other for one, other in zip(passes["state rules alone"], video, strict=True)]
        passes |= {"video alone": video, "both": both}
    success = [row["success"] for row in ran]
    return [
        {
            "filter": name,
            "precision": describe_share(sum(map(all, zip(admitted, success, strict=True))), sum(admitted)),
            "recall": describe_share(sum(map(all, zip(admitted, success, strict=True))), sum(success)),
        }
        for name, admitted in passes.items()
    ]


def _copy(folder: Path, target: Path) -> None:
    target.mkdir(parents=True)
    for name in ("episode.npz", "episode.json", VIDEO):
        shutil.copyfile(folder / name, target / name)


def _facts(table: pd.DataFrame, filters: Filters) -> Facts:
    """Shares of the attempts that were meant to succeed; those disturbed on purpose are no part of a pass rate."""
    meant, disturbed, video = table[~table.perturbed], table[table.perturbed], filters.discriminator

    def share(column: str) -> str:
        return describe_share(int(meant[column].sum()), len(meant))

    return {
        "accepted": share("accepted"),
        "judged_successful": share("success"),
        "pass_rules": share("rules_pass"),
        "pass_video": f"abstains: {video.reason}" if video.abstains else share("video_pass"),
        "disturbed_on_purpose_accepted": describe_share(int(disturbed.accepted.sum()), len(disturbed)),
        "filters_on_attempts_that_they_learned_from": compared_filters(table.to_dict("records")),
        "rejected": table.loc[~table.accepted, ["episode", "reasons"]].to_dict("records"),
    }
