"""`python -m sim1.recording.importing.c3d_worker FILE OUT`: a C3D file's points as arrays, in a process of their own.

ezc3d ends the whole process on some damaged files, and believes whatever size their header claims.
"""

import resource
import sys
from pathlib import Path

import numpy as np


def main(source: Path, out: Path) -> None:
    """Write points (T, M, 3), lost (T, M), labels, units, rate and the first frame (from 0) as `out`.npz."""
    most = 2 * 2**30 + 60 * source.stat().st_size
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    import ezc3d

    content = ezc3d.c3d(str(source))
    group, data = content["parameters"]["POINT"], content["data"]
    points = np.asarray(data["points"], float)[:3].transpose(2, 1, 0)
    lost = np.asarray(data["meta_points"]["residuals"])[0].T < 0
    names = [group[key]["value"] for key in sorted(group, key=lambda key: (len(key), key)) if key.startswith("LABELS")]
    np.savez(
        out,
        points=points,
        lost=lost | np.isnan(points).any(-1),  # zeros alone are no gap: a marker may be at the origin
        labels=np.array([str(label).strip() for some in names for label in some], dtype=str),
        units=np.array([str(unit).strip() for unit in group.get("UNITS", {}).get("value", [])], dtype=str),
        rate=np.ravel(group.get("RATE", {}).get("value", [])).astype(float),
        first_frame=content["header"]["points"]["first_frame"],
    )


if __name__ == "__main__":
    try:
        main(Path(sys.argv[1]), Path(sys.argv[2]))
    except Exception as error:  # damaged files raise many kinds; the caller wants one line
        sys.exit(" ".join(str(error).split())[:200] or type(error).__name__)
