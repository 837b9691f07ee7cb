"""Where each marker sits on the mesh: given by face and weights, or measured with a ruler along warp and weft."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.recording.importing.import_file import Anchor, ImportFile
from sim1.recording.importing.paths import numbers
from sim1.recording.importing.text_table import cell, check_width, numbered, read_cells
from sim1.recording.mesh import LARGEST, OFF_SHEET_M, RestMesh, place_on_mesh
from sim1.recording.places import Places
from sim1.recording.streams import LARGEST_ID, Anchors
from sim1.stage import BadInput

MEASURED, GIVEN = ["marker", "u_m", "v_m"], ["marker", "face", "b0", "b1", "b2"]


@dataclass(frozen=True, kw_only=True)
class _Table:
    """Anchors as they were given."""

    labels: list[str]  # n
    place: list[str]  # n, of each in its file
    face: np.ndarray  # (n,)
    weight: np.ndarray  # (n, 3) barycentric


def label_ids(path: Path, document: ImportFile, found: set[str]) -> dict[str, int]:
    """Id of each label that is on the cloth; with `labels: numbers` those of the `found` labels that are numbers.

    Raises:
        BadInput: no label is a number, an id is too large.
    """
    labels = document.markers.labels
    ids = labels if isinstance(labels, dict) else {label: int(label) for label in found if label.isdecimal()}
    if not ids:
        raise BadInput(
            f"{path}: markers.labels is numbers, and no label is one: {sorted(found)[:8]}; map each label to an id"
        )
    if (most := max(ids.values())) > LARGEST_ID:
        raise BadInput(f"{path}: markers.labels: id {most}; ids run from 0 to {LARGEST_ID}")
    return ids


def anchors_of(path: Path, document: ImportFile, ids: dict[str, int], mesh: RestMesh) -> tuple[Anchors, Places]:
    """Anchors of all labels, in the order of their ids, and where they stand; `path` is that of import.yaml.

    Raises:
        BadInput: a label without an anchor or an anchor without a label, a place off the mesh.
    """
    given = document.anchors
    if isinstance(given, str):
        source, table = path.parent / given, _from_csv(path, document, mesh)
    else:
        source, table = path, _from_list(path, given)
    labels, place = table.labels, table.place
    if len(set(labels)) < len(labels):
        twice = next(at for at, label in enumerate(labels) if label in labels[:at])
        raise BadInput(f"{place[twice]}: marker {labels[twice]!r} has two anchors; keep one")
    if lacking := sorted(set(ids) - set(labels)):
        raise BadInput(
            f"{source}: no anchor for marker {lacking[0]!r} ({len(lacking)} such); add it, or drop it from markers.labels"
        )
    chosen = sorted((ids[label], row) for row, label in enumerate(labels) if label in ids)
    rows = [row for _, row in chosen]
    places = Places(file=source, row=lambda k: f"{place[rows[k]]}: marker {labels[rows[k]]!r}")
    face = table.face[rows]
    if (off := (face < 0) | (face >= len(mesh.faces))).any():
        at = int(np.argmax(off))
        raise BadInput(f"{places.row(at)}: off the mesh: face {face[at]} of {len(mesh.faces)}; faces count from 0")
    anchors = Anchors(marker=np.array([marker for marker, _ in chosen]), face=face, weight=table.weight[rows])
    return anchors, places


def _from_list(path: Path, given: list[Anchor]) -> _Table:
    return _Table(
        labels=[anchor.marker for anchor in given],
        place=[f"{path}: anchors.{k}" for k in range(len(given))],
        face=np.array([anchor.face for anchor in given]),
        weight=np.array([anchor.weights for anchor in given], float).reshape(-1, 3),
    )


def _from_csv(path: Path, document: ImportFile, mesh: RestMesh) -> _Table:
    source = path.parent / document.anchors
    (first, head), *data = numbered(read_cells(source))
    if head not in (MEASURED, GIVEN):
        raise BadInput(f"{source}: row {first}: columns are {head}; expected {MEASURED} or {GIVEN}")
    if not data:
        raise BadInput(f"{source}: no rows below the header; give every marker a row")
    check_width(source, data, len(head))
    labels, place = [cell(cells, 0) for _, cells in data], [f"{source}: row {row}" for row, _ in data]
    text = [[cell(cells, k) for k in range(1, len(head))] for _, cells in data]
    values = numbers(source, text, [row for row, _ in data], f"every marker needs {head[1:]}")
    if (empty := ~np.isfinite(values).all(1)).any():
        raise BadInput(f"{place[np.argmax(empty)]}: a cell is empty; every marker needs {head[1:]}")
    if head == GIVEN:
        return _Table(labels=labels, place=place, face=_faces(values[:, 0], place), weight=values[:, 1:])
    if mesh.material_m is None:
        raise BadInput(
            f"{path.parent / document.garment.mesh}: no `vt`, along which {source} measures; export it with material coordinates "
            f"in metres, or give {GIVEN}"
        )
    face, weight, off = place_on_mesh(mesh, np.clip(values, -LARGEST, LARGEST))  # squares of what is beyond overflow
    if (far := off > OFF_SHEET_M).any():
        at = int(np.argmax(far))
        span = np.column_stack([mesh.material_m.min(0), mesh.material_m.max(0)])
        raise BadInput(
            f"{place[at]}: marker {labels[at]!r} at {values[at].tolist()} lies {off[at]:.3g} m off the mesh, "
            f"whose `vt` run over u {span[0].tolist()} and v {span[1].tolist()} m; measure in metres from the same corner"
        )
    return _Table(labels=labels, place=place, face=face, weight=weight)


def _faces(values: np.ndarray, place: list[str]) -> np.ndarray:
    if (odd := (values != np.round(values)) | (np.abs(values) > LARGEST_ID)).any():
        at = int(np.argmax(odd))
        raise BadInput(f"{place[at]}: face {values[at]:g}; faces are whole numbers, from 0")
    return values.astype(int)
