"""What a scan must look like before a mesh is made of it."""

import numpy as np

from sim1.scan.cloud import UNKNOWN_VIEW, Scan
from sim1.stage import Finding

_LONGEST_GAP = 25.0  # a point this many times the median spacing from its neighbours is a stray


def scan_findings(scan: Scan) -> list[Finding]:
    """Findings on finiteness, spacing, strays, what tells the garment from its support, and scanner distances."""
    from scipy.spatial import cKDTree

    cloud = scan.cloud
    finite = bool(np.isfinite(cloud.points_m).all())
    findings = [Finding(name="points_finite", passed=finite, detail=f"{len(cloud)} points, all finite: {finite}")]
    if not finite:
        return findings
    distance = cKDTree(cloud.points_m).query(cloud.points_m, k=5)[0][:, 4]
    spacing = float(np.median(distance))
    findings.append(
        Finding(
            name="spacing",
            passed=spacing < 0.01,
            detail=f"median distance to the 4th neighbour {spacing * 1e3:.2f} mm (limit 10 mm)",
        )
    )
    strays = float((distance > _LONGEST_GAP * spacing).mean())
    findings.append(
        Finding(
            name="few_strays",
            passed=strays < 0.01,
            detail=f"{strays:.2%} of the points stand alone (limit 1 %)",
            blocking=False,
        )
    )
    findings.append(_support_known(scan))
    known = cloud.view != UNKNOWN_VIEW
    if len(scan.scanner_to_world) and known.any():
        eye = scan.scanner_to_world[cloud.view[known], :3, 3]
        reach = float(np.median(np.linalg.norm(cloud.points_m[known] - eye, axis=1)))
        findings.append(
            Finding(
                name="scanner_distance",
                passed=0.05 < reach < 5.0,
                detail=f"median distance to the scanner {reach:.2f} m (0.05 to 5 m)",
            )
        )
    return findings


def _support_known(scan: Scan) -> Finding:
    given = "mask.npz" if scan.mask is not None else "support" if scan.support is not None else None
    detail = f"{given} tells the garment from what it lies or hangs on"
    if given is None:
        detail = (
            "neither support.ply nor mask.npz: nothing will be removed, and a table or mannequin in the scan becomes part of "
            "the garment; cut it away or give it as support.ply (docs/scan-format.md). All is well where the scan shows the "
            "garment alone"
        )
    return Finding(name="support_known", passed=given is not None, detail=detail, blocking=False)
