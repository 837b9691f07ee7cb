"""The canonical point cloud, as it stands in a `scan` artifact."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.array_file import read_arrays

UNKNOWN_VIEW = -1


@dataclass(frozen=True, kw_only=True)
class Cloud:
    """Points seen by a scanner; metres, front x, left y, up z."""

    points_m: np.ndarray  # (n, 3) float32
    colors: np.ndarray  # (n, 3) uint8
    view: np.ndarray  # (n,) int16, index of the scanner pose, UNKNOWN_VIEW where not known
    normals: np.ndarray  # (n, 3) float32, zeros where not known

    def __len__(self) -> int:
        return len(self.points_m)

    def only(self, keep: np.ndarray) -> "Cloud":
        """The points that a mask (n,) or an index keeps."""
        return Cloud(
            points_m=self.points_m[keep], colors=self.colors[keep], view=self.view[keep], normals=self.normals[keep]
        )


@dataclass(frozen=True, kw_only=True)
class Shape:
    """A triangle mesh; metres in a scan artifact."""

    vertices_m: np.ndarray  # (v, 3)
    faces: np.ndarray  # (f, 3) int32


@dataclass(frozen=True, kw_only=True)
class Scan:
    """All arrays of a `scan` artifact."""

    cloud: Cloud
    scanner_to_world: np.ndarray  # (v, 4, 4); v is 0 where no pose is known
    support: Shape | None = None  # mannequin or rack, in its own pose
    mask: np.ndarray | None = None  # (n,) bool: a person's choice of the garment's points
    truth: Shape | None = None  # virtual scans alone
    truth_label: np.ndarray | None = None  # (n,) bool: point lies on the garment; virtual scans alone


def write_scan(folder: Path, scan: Scan) -> None:
    """Write the arrays; absent parts make no file."""
    cloud = scan.cloud
    np.savez(
        folder / "points.npz", points_m=cloud.points_m, colors=cloud.colors, view=cloud.view, normals=cloud.normals
    )
    np.savez(folder / "views.npz", scanner_to_world=scan.scanner_to_world)
    if scan.support is not None:
        np.savez(folder / "support.npz", vertices_m=scan.support.vertices_m, faces=scan.support.faces)
    if scan.mask is not None:
        np.savez(folder / "mask.npz", garment=scan.mask)
    if scan.truth is not None:
        labels = {} if scan.truth_label is None else {"garment": scan.truth_label}
        np.savez(folder / "truth.npz", vertices_m=scan.truth.vertices_m, faces=scan.truth.faces, **labels)


def read_scan(folder: Path) -> Scan:
    """Read a `scan` artifact.

    Raises:
        BadInput: a file is missing or damaged.
    """
    points = read_arrays(folder / "points.npz", ("points_m", "colors", "view", "normals"))
    support, truth = (
        read_arrays(folder / name, ("vertices_m", "faces")) if (folder / name).exists() else None
        for name in ("support.npz", "truth.npz")
    )
    mask = read_arrays(folder / "mask.npz", ("garment",))["garment"] if (folder / "mask.npz").exists() else None
    return Scan(
        cloud=Cloud(**{name: points[name] for name in ("points_m", "colors", "view", "normals")}),
        scanner_to_world=read_arrays(folder / "views.npz", ("scanner_to_world",))["scanner_to_world"],
        support=None if support is None else Shape(vertices_m=support["vertices_m"], faces=support["faces"]),
        mask=mask,
        truth=None if truth is None else Shape(vertices_m=truth["vertices_m"], faces=truth["faces"]),
        truth_label=None if truth is None else truth.get("garment"),
    )
