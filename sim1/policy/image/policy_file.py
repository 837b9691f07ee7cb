"""Policy configurations as data: `data/policies/NAME.yaml`, read strictly."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from sim1.data_file import read_data_file
from sim1.stage import BadInput, stage_config

SCHEMA = "sim1.image_policy/1"
DECIDED_ELSEWHERE = {  # settings of lerobot's that this project fills in -> from what
    "chunk_size": "chunk_s of the stage",
    "horizon": "chunk_s of the stage",
    "n_action_steps": "chunk_s of the stage",
    "drop_n_last_frames": "chunk_s of the stage",
    "input_features": "the dataset: cameras and joint state",
    "output_features": "the dataset",
    "device": "device of the stage",
    "pretrained_path": "needs.weights of the file",
    "push_to_hub": "nothing: nothing is uploaded",
}

type Size = Literal["tiny", "small", "full"]


@stage_config
class Weights:
    """Published weights that training starts from."""

    folder: str = Field(min_length=1)  # of config.json and model.safetensors; relative to the policy file's folder
    source: str = Field(min_length=1)  # repository of the Hugging Face hub that publishes them
    fresh: tuple[str, ...] = ()  # beginnings of names of parameters that these do not have and that begin at random


@stage_config
class Needs:
    """What the machine must have beyond this project's set-up."""

    packages: tuple[str, ...] = ()  # Python packages
    extra: str = ""  # of lerobot, that installs them
    weights: Weights | None = None
    hub: tuple[str, ...] = ()  # repositories that lerobot reads by name, from the hub's cache on this machine
    gpu_gib: float = Field(0.0, ge=0)  # memory of an NVIDIA GPU; 0: runs on the CPU as well


@stage_config
class PolicyFile:
    """Contents of a policy file, schema `sim1.image_policy/1`."""

    title: str
    type: str = Field(pattern=r"^[a-z][a-z0-9_]*$")  # lerobot's name of the policy
    settings: dict[str, Any] = Field(default_factory=dict)  # of lerobot's configuration class, whatever the size
    sizes: dict[Size, dict[str, Any]] = Field(default_factory=dict)  # size of the stage -> settings that it adds
    needs: Needs = Needs()

    def at(self, size: Size) -> Mapping[str, Any]:
        """Settings at a size; those of the size take the place of the common ones."""
        return {**self.settings, **self.sizes.get(size, {})}


def read_policy_file(path: Path) -> PolicyFile:
    """Read one file.

    Raises:
        BadInput: missing, not readable, an unknown key, or a setting that is not the file's to make.
    """
    file = read_data_file(path, PolicyFile, SCHEMA)
    for place, settings in (("settings", file.settings), *((f"sizes.{size}", own) for size, own in file.sizes.items())):
        if taken := sorted(DECIDED_ELSEWHERE.keys() & settings.keys()):
            raise BadInput(
                f"{path}: {place}.{taken[0]} is {settings[taken[0]]!r}: it comes from {DECIDED_ELSEWHERE[taken[0]]}; remove it"
            )
    return file


def find_policy(folder: Path, name: str) -> tuple[Path, PolicyFile]:
    """Path and contents of the policy called `name`.

    Raises:
        BadInput: there is none of that name, or its file is at fault.
    """
    known = {path.stem: path for path in sorted(folder.glob("*.yaml"))}
    if name not in known:
        raise BadInput(
            f"{folder}: no policy {name!r}; there are {', '.join(known) or 'none'} (setting `policy` of stage image_policy)"
        )
    return known[name], read_policy_file(known[name])
