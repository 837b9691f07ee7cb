"""Whether this machine has what a policy needs. What is missing is named with its remedy; nothing is put in its place."""

import importlib.metadata
import importlib.util
from pathlib import Path

import safetensors
import torch
from huggingface_hub import snapshot_download

from sim1.policy.image.policy_file import PolicyFile, Weights
from sim1.stage import BadInput

GPU, CPU = "cuda", "cpu"  # torch's names


def gpu_memory_gib() -> float:
    """Memory of the GPU that torch would use; 0 where there is none."""
    return torch.cuda.get_device_properties(0).total_memory / 2**30 if torch.cuda.is_available() else 0.0


def choose_device(path: Path, file: PolicyFile, wanted: str) -> str:
    """Torch's name of the device to train on.

    Args:
        path: of the policy file, for messages.
        file: its contents.
        wanted: `auto` takes a GPU where there is one, `cpu` and `gpu` insist.

    Raises:
        BadInput: something that the policy needs is not on this machine; the message names all of it.
    """
    found_gib = gpu_memory_gib() if wanted != "cpu" else 0.0
    faults = [
        *_missing_packages(file),
        *_missing_weights(path, file.needs.weights),
        *(_missing_cache(name) for name in file.needs.hub if not _cached(name)),
        *_missing_gpu(file.needs.gpu_gib, wanted, found_gib),
    ]
    if faults:
        raise BadInput(
            f"{path}: policy {path.stem!r} cannot be trained here; what is missing: {'; '.join(faults)}. "
            "Or choose another policy with the setting `policy` of stage image_policy, such as act"
        )
    return GPU if found_gib else CPU


def weights_folder(path: Path, weights: Weights) -> Path:
    """Where the weights that a policy file names are to lie."""
    return (path.parent / weights.folder).resolve()


def _missing_packages(file: PolicyFile) -> list[str]:
    absent = [name for name in file.needs.packages if importlib.util.find_spec(name) is None]
    if not absent:
        return []
    package = f"lerobot[{file.needs.extra}]" if file.needs.extra else " ".join(absent)
    version = f"=={importlib.metadata.version('lerobot')}" if file.needs.extra else ""
    return [
        f"the Python package {', '.join(absent)} (uv pip install --python .venv/bin/python '{package}{version}', again after each set-up)"
    ]


def _missing_weights(path: Path, weights: Weights | None) -> list[str]:
    if weights is None:
        return []
    folder = weights_folder(path, weights)
    try:
        if not (folder / "config.json").is_file():
            raise FileNotFoundError("no config.json")
        with safetensors.safe_open(folder / "model.safetensors", framework="pt"):
            return []  # its header is whole
    except (OSError, safetensors.SafetensorError) as error:
        return [f"weights in {folder} ({error}; with a network: hf download {weights.source} --local-dir {folder})"]


def _cached(name: str) -> bool:
    try:
        snapshot_download(name, local_files_only=True)
    except OSError:  # the hub's errors for what is not there are among these
        return False
    return True


def _missing_cache(name: str) -> str:
    return f"{name} in the hub's cache (with a network: hf download {name})"


def _missing_gpu(needed_gib: float, wanted: str, found_gib: float) -> list[str]:
    if found_gib >= needed_gib and (found_gib or wanted != "gpu"):
        return []
    if wanted == "cpu":
        return [
            f"a GPU with {needed_gib:g} GiB (the setting `device` is cpu: set it to auto on a machine that has one)"
        ]
    size = f" with {needed_gib:g} GiB" if needed_gib else ""
    found = f"this one has {found_gib:.0f} GiB" if found_gib else "torch finds none"
    return [f"a GPU{size} ({found}; run on a machine that has one{'' if needed_gib else ', or set `device` to auto'})"]
