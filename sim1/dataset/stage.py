"""Stage `dataset`: every garment's rendered episodes as one LeRobot v3 dataset, with its card and its provenance."""

from pathlib import Path
from typing import Literal

from pydantic import Field

from sim1.data_file import read_data_file
from sim1.stage import BadInput, Facts, Finding, Inputs, only, stage_config

SCHEMA = "sim1.dataset/1"  # of data/dataset.yaml
NAME = "sim1/folding"  # LeRobot wants an owner and a name; nothing is looked up under it


@stage_config
class DatasetConfig:
    """How the dataset is written."""

    keypoint_count: int = Field(12, ge=1)  # garment vertices in privileged.garment_keypoints, as many of every garment
    codec: Literal["h264", "libsvtav1"] = "h264"  # h264 decodes everywhere; libsvtav1 (AV1) is smaller and slower
    crf: int = Field(23, ge=0, le=63)  # constant rate factor: lower is better and larger; the worst of h264 is 51
    keyframe_interval: int = Field(2, ge=1, le=1000)  # frames; short, because training reads frames in random order


@stage_config
class DatasetFile:
    """Contents of `data/dataset.yaml`, schema `sim1.dataset/1`: what the owner of the data decides."""

    license: str = Field("unknown", pattern=r"^[A-Za-z0-9][A-Za-z0-9.+-]*$")  # SPDX name for the card


def dataset(inputs: Inputs, out: Path, config: DatasetConfig) -> Facts:
    """Write `lerobot/`, `README.md`, `provenance.parquet`, `keypoints.json`, `limits.json` and pictures.

    Raises:
        BadInput: nothing to write, the garments were rendered at different rates, sizes or with different cameras, a mesh has
            fewer vertices than `keypoint_count`, or an input is damaged.
    """
    from sim1.dataset.card import write_card
    from sim1.dataset.decisions import read_decisions
    from sim1.dataset.limits import write_limits
    from sim1.dataset.physics import known_physics
    from sim1.dataset.sources import read_clips
    from sim1.dataset.write import Known, write_dataset
    from sim1.scene.description import read_scene

    artifacts = inputs.get("rendered_episodes", {})
    if not artifacts:
        raise BadInput("dataset: no rendered episodes of any garment; make the stage rendered_episodes first")
    clips = [clip for garment in sorted(artifacts) for clip in read_clips(artifacts[garment], garment)]
    if not clips:
        raise BadInput(
            f"dataset: the rendered episodes of {', '.join(sorted(artifacts))} are empty; no trajectory was accepted"
        )
    models, reports, filtered, scenes = (
        inputs.get(stage, {}) for stage in ("calibrated_physics", "mismatch_report", "valid_trajectories", "scene")
    )
    known = {
        garment: Known(
            physics=known_physics(models.get(garment), reports.get(garment)),
            decisions=read_decisions(filtered[garment]) if garment in filtered else None,
            scene=read_scene(scenes[garment]) if garment in scenes else None,
        )
        for garment in artifacts
    }
    provenance = write_dataset(clips, out, config, name=NAME, known=known)
    write_limits(out, only(inputs, "robot"))
    owner = read_data_file(only(inputs, "owner"), DatasetFile, SCHEMA) if inputs.get("owner") else DatasetFile()
    return write_card(out, provenance, name=NAME, licenses=(owner.license,))


def check_source_owner(path: Path) -> None:
    """Raises BadInput where `data/dataset.yaml` is at fault: before any work, rather than at the end of it."""
    read_data_file(path, DatasetFile, SCHEMA)


def check_dataset(artifact: Path) -> list[Finding]:
    """Consistency of the LeRobot dataset, the robot's joint limits, and pictures that belong to the states beside them."""
    from sim1.dataset.check import check_lerobot
    from sim1.dataset.check_provenance import check_provenance
    from sim1.dataset.limits import read_limits

    return [*check_lerobot(artifact / "lerobot", limits=read_limits(artifact)), *check_provenance(artifact)]
