"""Facts, tables and pictures of an artifact as Dagster metadata that a person can read in the UI."""

import base64
import io
from pathlib import Path
from typing import Any

import dagster as dg

from assets_defs._produce import Made

PICTURES_AT_MOST = 4
PICTURE_BYTES_AT_MOST = 120_000  # they live in the event log


def metadata(made: Made) -> dict[str, Any]:
    """Metadata of a materialization: facts, pictures, what it was made from."""
    found: dict[str, Any] = {}
    for name, value in made.record["facts"].items():
        found[name] = _value(value)
    for picture in sorted(made.path.glob("*.png"))[:PICTURES_AT_MOST]:
        found[f"picture: {picture.stem}"] = dg.MetadataValue.md(f"![{picture.stem}]({picture_uri(picture)})")
    kept = ("recipe", "parts", "data_version", "seconds", "findings")
    found["record"] = dg.MetadataValue.json({name: made.record[name] for name in kept})
    found["seconds"] = dg.MetadataValue.float(made.record["seconds"])
    found["path"] = dg.MetadataValue.path(str(made.path))
    return found


def _value(value: Any) -> Any:
    if isinstance(value, list) and value and all(isinstance(row, dict) for row in value):
        return dg.MetadataValue.table([dg.TableRecord(_flat(row)) for row in value])
    if isinstance(value, dict | list):
        return dg.MetadataValue.json(value)
    if value is None:
        return dg.MetadataValue.text("not measured")
    return value


def _flat(row: dict[str, Any]) -> dict[str, Any]:
    return {name: value if isinstance(value, str | int | float | bool) else str(value) for name, value in row.items()}


def picture_uri(path: Path) -> str:
    """The picture as a data address, made smaller until it fits the event log."""
    data = path.read_bytes()
    if len(data) > PICTURE_BYTES_AT_MOST:
        from PIL import Image

        image = Image.open(path).convert("RGB")
        while len(data) > PICTURE_BYTES_AT_MOST:
            image = image.resize((max(1, image.width * 3 // 4), max(1, image.height * 3 // 4)))
            buffer = io.BytesIO()
            image.save(buffer, "PNG", optimize=True)
            data = buffer.getvalue()
    return "data:image/png;base64," + base64.b64encode(data).decode()
