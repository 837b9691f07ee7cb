"""What a simulation mesh must be: connected, manifold, oriented, even, open where the garment is open, and accurate."""

import json
from pathlib import Path

import numpy as np

from sim1.array_file import read_arrays
from sim1.scan.pieces import face_components
from sim1.scan.remesh import corner_angles_rad
from sim1.scan.rims import rim_lengths_m
from sim1.stage import Finding

ANGLE_DEG = 15.0
RMS_MM = 0.5  # before remeshing: the paper claims sub-millimetre
COARSE_MM = 4.0  # after it: chords of a coarse mesh across a curved sleeve


def mesh_findings(folder: Path) -> list[Finding]:
    """Findings on the arrays of `mesh.npz` and the figures of `accuracy.json`."""
    arrays = read_arrays(folder / "mesh.npz", ("vertices_m", "faces", "uv", "rest_m"))
    figures = json.loads((folder / "accuracy.json").read_text())
    vertices, faces, rest = (arrays[name] for name in ("vertices_m", "faces", "rest_m"))
    finite = all(bool(np.isfinite(arrays[name]).all()) for name in ("vertices_m", "uv", "rest_m"))
    findings = [Finding(name="finite", passed=finite, detail=f"all coordinates finite: {finite}")]
    if not finite or faces.min() < 0 or faces.max() >= len(vertices):
        return [
            *findings,
            Finding(
                name="indices", passed=False, detail=f"face indices {faces.min()} to {faces.max()} of {len(vertices)}"
            ),
        ]
    unused = len(vertices) - len(np.unique(faces))
    findings.append(
        Finding(name="vertices_used", passed=unused == 0, detail=f"{unused} of {len(vertices)} vertices in no face")
    )
    pieces = int(face_components(faces, np.ones(len(faces), bool)).max()) + 1
    findings.append(Finding(name="one_piece", passed=pieces == 1, detail=f"{pieces} connected component(s)"))
    findings += _topology(faces)
    angle = float(np.degrees(corner_angles_rad(vertices.astype(float), faces).min()))
    findings.append(
        Finding(name="minimum_angle", passed=angle >= ANGLE_DEG, detail=f"{angle:.1f} degrees (at least {ANGLE_DEG:g})")
    )
    rest_angle = float(np.degrees(corner_angles_rad(rest.astype(float), faces).min()))
    findings.append(
        Finding(
            name="rest_angle",
            passed=rest_angle >= ANGLE_DEG - 1,
            detail=f"{rest_angle:.1f} degrees in the rest shape (at least {ANGLE_DEG - 1:g})",
        )
    )
    loops = rim_lengths_m(vertices.astype(float), faces)
    findings.append(
        Finding(
            name="openings",
            passed=len(loops) == figures["openings_expected"],
            detail=f"{len(loops)} boundary loops, the garment has {figures['openings_expected']}; {[round(x, 3) for x in loops]} m",
        )
    )
    inside = bool((arrays["uv"] >= 0).all() and (arrays["uv"] <= 1).all())
    findings.append(Finding(name="texture_coordinates", passed=inside, detail=f"all in [0, 1]: {inside}"))
    return [*findings, *_accuracy(figures), _removal(figures["separation"])]


def _removal(separation: dict) -> Finding:
    """A manual mask is obeyed even where it keeps everything; otherwise nothing removed is worth a look."""
    removed, count = separation["all_points"] - separation["garment_points"], separation["all_points"]
    passed = separation["method"] == "manual mask" or (separation["method"] == "registered support" and removed > 0)
    detail = f"{separation['method']}: {removed} of {count} points left out"
    if not passed:
        detail += (
            "; what the garment lay or hung on, if the scan shows it, is part of this mesh: look at separation.png, cut it "
            "away or give it as support.ply (docs/scan-format.md)"
        )
    return Finding(name="support_removed", passed=passed, detail=detail, blocking=False)


def _topology(faces: np.ndarray) -> list[Finding]:
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    directed = len(edges) - len(np.unique(edges, axis=0))
    # Around a manifold vertex the faces form one fan: no rim edge (inside) or two (on a rim).
    unique, uses = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    crowded = int((uses > 2).sum())
    pinched = int((np.bincount(unique[uses == 1].ravel(), minlength=1) > 2).sum())
    return [
        Finding(
            name="manifold",
            passed=crowded == 0 and pinched == 0,
            detail=f"{crowded} edges with more than 2 faces, {pinched} pinched vertices",
        ),
        Finding(
            name="orientation_consistent", passed=directed == 0, detail=f"{directed} edges run twice in one direction"
        ),
    ]


def _accuracy(figures: dict) -> list[Finding]:
    findings = []
    for against in ("points_to_mesh", "mesh_to_points", "mesh_to_truth"):
        if against in figures["before_remeshing"]:
            rms = figures["before_remeshing"][against]["rms_mm"]
            findings.append(
                Finding(
                    name=f"{against}_rms",
                    passed=rms <= RMS_MM,
                    detail=f"{rms:.3f} mm before remeshing (at most {RMS_MM} mm)",
                )
            )
    rms = figures["after_remeshing"]["points_to_mesh"]["rms_mm"]
    findings.append(
        Finding(
            name="simulation_mesh_rms",
            passed=rms <= COARSE_MM,
            detail=f"{rms:.2f} mm after remeshing (at most {COARSE_MM:g} mm)",
        )
    )
    agree = figures["normals_agree"]
    findings.append(
        Finding(
            name="outward",
            passed=agree > 0.9,
            detail=f"{agree:.1%} of the mesh faces the side the scanner saw (more than 90 %)",
        )
    )
    return findings
