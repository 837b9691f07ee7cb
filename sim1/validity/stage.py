"""Stages of the validity room: state_rules, video_discriminator, valid_trajectories."""

import json
from pathlib import Path

from pydantic import Field

from sim1.stage import Facts, Finding, Inputs, garment_of, only, stage_config


@stage_config
class StateRulesConfig:
    """How threshold rules are learned."""

    depth: int = Field(3, ge=1, le=3)  # of the tree: a person can still read it
    recall_floor: float = Field(0.9, gt=0, le=1)  # share of the successes that the rules must admit
    margin: float = Field(0.5, ge=0)  # of an interval, as a share of the successes' range: few runs show little of it
    minimum_per_class: int = Field(8, ge=2)  # a tree on fewer successes or failures only learns their names


@stage_config
class VideoDiscriminatorConfig:
    """The network that looks at head-view video."""

    seed: int = 0  # initial weights, batches
    width: int = Field(64, ge=16, multiple_of=8)  # of the transformer over time
    layer_count: int = Field(2, ge=1)
    frame_count: int = Field(8, ge=2)  # of a clip, spread over the episode
    frame_width: int = Field(64, ge=32, le=112)  # px; that of the candidates' video, demonstrations are drawn like it
    frame_height: int = Field(48, ge=32, le=112)  # px
    step_count: int = Field(20, ge=1)  # optimizer steps, about 0.6 s each on one core
    batch_size: int = Field(4, ge=2, multiple_of=2)  # clips, half of them failures
    learning_rate: float = Field(3e-4, gt=0)
    precision: float = Field(0.99, gt=0, le=1)  # wanted among accepted clips; sets the threshold
    minimum_per_class: int = Field(3, ge=1)  # with fewer successes or failures it abstains
    minimum_held_out: int = Field(4, ge=1)  # of each among the calibration and among the test clips: fewer say nothing


@stage_config
class ValidTrajectoriesConfig:
    """Which filters decide."""

    require_success: bool = True  # the task was done, by the judge's figures
    use_rules: bool = True  # state rules, as in the paper
    minimum_accepted: int = Field(1, ge=0)  # fewer accepted trajectories are no training set; 0 for what may fail
    use_video: bool = True  # video discriminator, as in the paper; where it abstains the others decide


def state_rules(inputs: Inputs, out: Path, config: StateRulesConfig) -> Facts:
    """Learn readable threshold rules over particle features from successful and failed runs."""
    from sim1.cloth.garment import read_garment_mesh
    from sim1.validity.learning import learn

    mesh = read_garment_mesh(only(inputs, "garment_mesh"))
    return learn(only(inputs, "seed_demos"), only(inputs, "candidate_trajectories"), mesh, config, out)


def check_state_rules(artifact: Path) -> list[Finding]:
    """The rules read, and admit at least the wanted share of the successes they were learned from."""
    import pandas as pd

    from sim1.validity.rules import admissible, read_rules

    rules = read_rules(artifact / "rules.yaml")
    table = pd.read_parquet(artifact / "features.parquet")
    floor = float(json.loads((artifact / "training.json").read_text())["recall_floor"])
    good = table[table.success]
    kept = int(admissible(rules, good).sum())
    bad = table[~table.success]
    rejected = int((~admissible(rules, bad)).sum()) if len(bad) else 0
    return [
        Finding(
            name="recall_floor",
            passed=kept >= floor * len(good),
            detail=f"{kept} of {len(good)} successes admitted, floor {floor:.0%}",
        ),
        Finding(
            name="rejects_failures",
            passed=rejected > 0,
            detail=f"{rejected} of {len(bad)} failures rejected, expected at least 1",
            blocking=False,  # there may be no failure to learn from
        ),
    ]


def video_discriminator(inputs: Inputs, out: Path, config: VideoDiscriminatorConfig) -> Facts:
    """Train the discriminator on demonstrations and candidates, or abstain and say why.

    Raises:
        BadInput: an input is damaged, or the candidates' video has frames of another size than `config`.
    """
    from sim1.cloth.garment import read_garment_mesh
    from sim1.scene.description import read_scene
    from sim1.validity.watching import watch

    mesh = read_garment_mesh(only(inputs, "garment_mesh"))
    scene = read_scene(only(inputs, "scene"))
    folders = (only(inputs, "seed_demos"), only(inputs, "candidate_trajectories"))
    return watch(*folders, mesh, scene, garment_of(inputs), config, out)


def check_video_discriminator(artifact: Path) -> list[Finding]:
    """The model reads; where it decides, the scores of clips that had no say in it stand behind it."""
    from sim1.statistics import describe_share
    from sim1.validity.evidence import doubt, outcome
    from sim1.validity.watching import read_discriminator, scored

    model = read_discriminator(artifact)
    metrics = json.loads((artifact / "metrics.json").read_text())
    test = outcome(*scored(metrics["scores"], "test"), model.threshold)
    unsupported = "" if model.abstains else doubt(test, metrics["wanted_precision"], metrics["minimum_held_out"])
    return [
        Finding(
            name="decides_only_with_evidence",
            passed=not unsupported,
            detail=model.reason
            or unsupported
            or f"of the test clips that it accepts {describe_share(test.accepted_success, test.accepted)} are successes",
        ),
        Finding(
            name="decides",
            passed=not model.abstains,
            detail=model.reason or "it decides",
            blocking=False,  # with few clips it is right to abstain
        ),
    ]


def valid_trajectories(inputs: Inputs, out: Path, config: ValidTrajectoriesConfig) -> Facts:
    """Apply judge, rules and discriminator to every candidate; keep the accepted ones, explain all (paper, Algorithm 1)."""
    from sim1.validity.deciding import decide

    return decide(inputs, garment_of(inputs), config, out)


def check_valid_trajectories(artifact: Path) -> list[Finding]:
    """Enough trajectories are accepted, every decision has a reason, and the episodes are those decided for."""
    import pandas as pd

    from sim1.episode import episode_folders

    table = pd.read_parquet(artifact / "decisions.parquet")
    minimum = json.loads((artifact / "limits.json").read_text())["minimum_accepted"]
    accepted = table[table.accepted]
    unexplained = table[~table.accepted & (table.reasons.str.len() == 0)]
    folders = [folder.name for folder in episode_folders(artifact)]
    reasons = table.loc[~table.accepted, "reasons"].value_counts()
    why = "; ".join(f"{count} x {reason[:120]}" for reason, count in reasons.items())
    return [
        Finding(
            name="something_accepted",
            passed=len(accepted) >= minimum,
            detail=f"{len(accepted)} of {len(table)} candidates accepted, expected at least {minimum}"
            + (f": {why}" if why else ""),
        ),
        Finding(
            name="rejections_explained",
            passed=unexplained.empty,
            detail=f"{len(unexplained)} rejected candidates without a reason, limit 0",
        ),
        Finding(
            name="episodes_match_decisions",
            passed=sorted(accepted.episode) == folders,
            detail=f"{len(folders)} episodes for {len(accepted)} accepted candidates",
        ),
        Finding(
            name="accepted_succeeded",
            passed=bool(accepted.success.all()),
            detail=f"{int((~accepted.success).sum())} accepted candidates failed the task, limit 0",
            blocking=False,  # a variant may switch the judge off
        ),
    ]
