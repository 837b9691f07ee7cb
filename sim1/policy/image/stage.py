"""Stage `image_policy`: policies of lerobot's that see pictures and joint state, tried on changed pictures."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from sim1.stage import Facts, Finding, Inputs, distinct, stage_config


@stage_config
class ImagePolicyConfig:
    """Which policy, how long it learns, and on what it is tried."""

    seed: int = 0  # of the split (the same seed holds out what stage `policy` holds out) and of the changed looks
    # One network each, which draws its first weights and the order of the frames; all of them learn from the same ones.
    seeds: Annotated[tuple[int, ...], Field(min_length=1), AfterValidator(distinct)] = (0,)
    policy: str = "act"  # name of a file in data/policies/
    size: Literal["tiny", "small", "full"] = "tiny"  # settings under `sizes` of that file
    test_share: float = Field(0.25, gt=0, lt=1)  # of each garment's trajectories, wanted for the test
    steps: int = Field(100, gt=0)  # gradient steps
    batch: int = Field(8, gt=0)  # frames per step
    chunk_s: float = Field(1.0, gt=0)  # commands predicted, and compared, at once
    device: Literal["auto", "cpu", "gpu"] = "auto"  # auto takes a GPU where there is one; gpu is not deterministic
    # These four change no byte of the policies, and so are no part of the recipe.
    processes: int = Field(0, ge=0, exclude=True)  # networks at once; 0: one per core, or one where there is a GPU
    workers: int = Field(0, ge=0, exclude=True)  # processes that decode videos; 0 decodes between the steps
    kept_mib: int = Field(512, ge=0, exclude=True)  # of decoded pictures, for each of these processes or networks
    checkpoint_s: float = Field(60.0, ge=0, exclude=True)  # a killed training loses at most that much
    evaluate_every: int = Field(
        1, ge=1
    )  # only every so many frames of a held-out trajectory are tried, and rendered anew
    shifted_trajectories: int = Field(1, ge=0)  # held-out ones rendered anew with one thing changed, garments in turn
    shifted_first: tuple[str, ...] = ("towel",)  # preferred for it, where the dataset has them; then by name
    viewpoint_deg: float = Field(
        5.0, ge=0, le=30
    )  # of the head camera's elevation, beyond all that training has seen (paper, 4.1)


def image_policy(inputs: Inputs, out: Path, config: ImagePolicyConfig) -> Facts:
    """Train one policy per seed on the dataset's pictures, measure their error on held-out trajectories and on changed pictures.

    What `out` already holds of an interrupted run is gone on with.

    Raises:
        BadInput: the dataset is damaged, or the policy's file, weights, packages or GPU are missing or at fault.
        BlenderFailed: the changed pictures could not be rendered.
        CrewDied: processes that trained have died; what is made stays.
    """
    from sim1.policy.image.experiment import run_experiment

    return run_experiment(inputs, out, config)


def check_image_policy(artifact: Path) -> list[Finding]:
    """Lerobot loads the policies again, their weights are finite, every planned error was measured and is on the page."""
    from sim1.policy.image.checks import check_experiment

    return check_experiment(artifact)


def check_source_policies(path: Path) -> None:
    """Raises BadInput where a policy file is at fault: before any work, rather than at the end of it."""
    from sim1.policy.image.policy_file import read_policy_file

    for file in sorted(path.glob("*.yaml")):
        read_policy_file(file)
