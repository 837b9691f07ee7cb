"""A small trained network as two files: `model.json` (what it is) and `model.safetensors` (its weights)."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import safetensors.torch
import torch
from torch.nn import Module

from sim1.stage import BadInput


def write_network(folder: Path, network: Module | None, about: Mapping[str, Any]) -> None:
    """Write both files; without a network the weights are a placeholder. `about` holds the key `schema`."""
    weights = network.state_dict() if network is not None else {"none": torch.zeros(1)}
    safetensors.torch.save_file(
        {name: value.contiguous() for name, value in weights.items()}, folder / "model.safetensors"
    )
    (folder / "model.json").write_text(json.dumps(about, indent=1, sort_keys=True) + "\n")


def read_network[T](folder: Path, schema: str, stage: str, build: Callable[[dict[str, Any], Path], T]) -> T:
    """What `build` makes of the contents of `model.json` and the path of the weights.

    Raises:
        BadInput: a file is missing, damaged, or of another schema, or `build` finds it so; names the stage to run again.
    """
    try:
        about = json.loads((folder / "model.json").read_text())
        if about.get("schema") != schema:
            raise ValueError(f"schema is {about.get('schema')!r}, expected {schema!r}")
        return build(about, folder / "model.safetensors")
    except (OSError, ValueError, KeyError, TypeError, RuntimeError, safetensors.SafetensorError) as error:
        raise BadInput(f"{folder}: not a readable model ({error}); make {stage} again") from error


def load_weights[M: Module](network: M, path: Path) -> M:
    """The network with the weights of a file, ready for use."""
    network.load_state_dict(safetensors.torch.load_file(path))
    return network.eval()
