"""What is known of the cloth that the episodes were simulated with, for their provenance."""

import hashlib
import json
from pathlib import Path
from typing import Any

from sim1.cloth.cell_physics import effects_left_out
from sim1.cloth.physics import CONTACTS, SCALARS, read_physics
from sim1.stage import BadInput


def known_physics(calibrated: Path | None, mismatch: Path | None) -> dict[str, Any] | None:
    """The garment's model in a few JSON values; None where the pipeline has none.

    Args:
        calibrated: artifact of `calibrated_physics`: what was found of the fabric, and `cell.yaml`, what demonstrations and
            candidates are simulated with.
        mismatch: artifact of `mismatch_report`: whether what was found explains the recordings.

    Raises:
        BadInput: an artifact is damaged.
    """
    if calibrated is None:
        return None
    path = calibrated / "cell.yaml"
    model = read_physics(path)
    left_out = effects_left_out(read_physics(calibrated / "model.yaml"), model)
    return {
        "model_sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
        "values": {name: getattr(model, name).value for name in SCALARS},
        "friction": {name: getattr(model.friction, name).value for name in CONTACTS},
        "effects": [str(effect["name"]) for effect in model.effects],
        "effects_not_simulated": list(left_out),
        "verdict": None if mismatch is None else _verdict(mismatch / "verdict.json"),
    }


def _verdict(path: Path) -> str:
    try:
        return str(json.loads(path.read_text())["verdict"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{path}: not a readable verdict ({error}); make the mismatch report again") from error
