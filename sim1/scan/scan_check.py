"""What a scan must look like before a mesh is made of it."""

import numpy as np

from sim1.scan.cloud import UNKNOWN_VIEW, Scan
from sim1.stage import Finding

_LONGEST_GAP = 25.0  # a point this many times the median spacing from its neighbours is a stray


def scan_findings(scan: Scan) -> list[Finding]:
    """Findings on finiteness, spacing, strays, and scanner distances."""
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
