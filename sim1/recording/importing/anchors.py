"""Where each marker sits on the mesh: given by face and weights, or measured with a ruler along warp and weft."""

from pathlib import Path

import numpy as np

from sim1.recording.importing.import_file import Anchor, ImportFile
from sim1.recording.importing.paths import numbers
from sim1.recording.importing.text_table import cell, read_cells
from sim1.recording.mesh import OFF_SHEET_M, RestMesh, place_on_mesh
from sim1.recording.streams import LARGEST_ID, Anchors
from sim1.stage import BadInput

MEASURED, GIVEN = ["marker", "u_m", "v_m"], ["marker", "face", "b0", "b1", "b2"]


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


def anchors_of(path: Path, document: ImportFile, ids: dict[str, int], mesh: RestMesh) -> Anchors:
    """Anchors of all labels, in the order of their ids; `path` is that of import.yaml.

    Raises:
        BadInput: a label without an anchor or an anchor without a label, a place off the mesh.
    """
    if isinstance(document.anchors, str):
        source = path.parent / document.anchors
        labels, face, weight = _from_csv(source, mesh)
    else:
        source, given = path, document.anchors
        labels, (face, weight) = [anchor.marker for anchor in given], _from_list(given)
    if len(set(labels)) < len(labels):
        twice = next(label for label in labels if labels.count(label) > 1)
        raise BadInput(f"{source}: marker {twice!r} has two anchors; keep one")
    if lacking := sorted(set(ids) - set(labels)):
        raise BadInput(
            f"{source}: no anchor for marker {lacking[0]!r} ({len(lacking)} such); add it, or drop it from markers.labels"
        )
    chosen = sorted((ids[label], row) for row, label in enumerate(labels) if label in ids)
    rows = [row for _, row in chosen]
    marker = np.array([marker for marker, _ in chosen])
    if (off := (face[rows] < 0) | (face[rows] >= len(mesh.faces))).any():
        at = rows[int(np.argmax(off))]
        raise BadInput(f"{source}: marker {labels[at]!r}: face {face[at]} of {len(mesh.faces)}; faces count from 0")
    return Anchors(marker=marker, face=face[rows], weight=weight[rows])


def _from_list(given: list[Anchor]) -> tuple[np.ndarray, np.ndarray]:
    return np.array([anchor.face for anchor in given]), np.array([anchor.weights for anchor in given], float).reshape(
        -1, 3
    )


def _from_csv(source: Path, mesh: RestMesh) -> tuple[list[str], np.ndarray, np.ndarray]:
    rows = read_cells(source)
    head, data = rows[0], [(row + 1, cells) for row, cells in enumerate(rows) if row and cells]
    if head not in (MEASURED, GIVEN):
        raise BadInput(f"{source}: row 1: columns are {head}; expected {MEASURED} or {GIVEN}")
    labels = [cell(cells, 0) for _, cells in data]
    values = numbers(
        source, [[cell(cells, k) for k in range(1, len(head))] for _, cells in data], [row for row, _ in data]
    )
    if (empty := ~np.isfinite(values).all(1)).any():
        raise BadInput(
            f"{source}: row {data[int(np.argmax(empty))][0]}: a cell is empty; every marker needs {head[1:]}"
        )
    if head == GIVEN:
        if (part := values[:, 0] != np.round(values[:, 0])).any():
            raise BadInput(
                f"{source}: row {data[int(np.argmax(part))][0]}: face {values[np.argmax(part), 0]}; faces are whole numbers"
            )
        return labels, values[:, 0].astype(int), values[:, 1:]
    face, weight, off = place_on_mesh(mesh, values)
    if (far := off > OFF_SHEET_M).any():
        at = int(np.argmax(far))
        span = np.column_stack(
            [mesh.material_m.min(0), mesh.material_m.max(0)]
        )  # place_on_mesh saw that there are some
        raise BadInput(
            f"{source}: row {data[at][0]}: marker {labels[at]!r} at {values[at].tolist()} lies {off[at]:.3g} m off the mesh, "
            f"whose `vt` run over u {span[0].tolist()} and v {span[1].tolist()} m; measure in metres from the same corner"
        )
    return labels, face, weight
