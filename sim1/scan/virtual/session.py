"""A scanning session: all views of a garment on its support, fused and written as a scan folder."""

import json
from pathlib import Path

import numpy as np

from sim1.progress import track
from sim1.scan.cloud import Shape
from sim1.scan.ply import write_ply
from sim1.scan.virtual.bodies import joined
from sim1.scan.virtual.garments import Staged
from sim1.scan.virtual.scanner import Scanner, look, look_at
from sim1.stage import random_stream

_COLOR_NOISE = 3.0  # standard deviation of a colour value, of 255


def scan_garment(folder: Path, staged: Staged, *, seed: int, name: str, scanner: Scanner | None = None) -> None:
    """Write `scan.ply`, `views.json`, `support.ply` and `truth.npz` into `folder`."""
    rng = random_stream(seed, name, "virtual scan")
    scene = joined(staged.garment, staged.support)
    poses, seen = [], []
    for index, (eye, target) in enumerate(
        track(list(zip(staged.eyes, staged.targets, strict=True)), f"views of {name}")
    ):
        pose = look_at(eye, target)
        view = look(scanner or Scanner(), pose, scene.vertices_m, scene.faces, rng)
        poses.append(pose)
        seen.append((view.points_m, view.exact_m, view.face, np.full(len(view.face), index)))
    points, exact, face, view_index = (np.concatenate(part) for part in zip(*seen, strict=True))
    keep = thin(points, staged.cell_m, rng)
    points, exact, face, view_index = points[keep], exact[keep], face[keep], view_index[keep]

    on_garment = face < len(staged.garment.faces)
    colors = np.where(on_garment[:, None], staged.color(exact), staged.support_rgb) + rng.normal(
        0.0, _COLOR_NOISE, points.shape
    )
    colors = np.clip(np.round(colors), 0, 255).astype(np.uint8)

    folder.mkdir(parents=True, exist_ok=True)
    vertex = dict(zip("xyz", points.astype(np.float32).T, strict=True))
    vertex |= dict(zip(("red", "green", "blue"), colors.T, strict=True)) | {"view": view_index.astype(np.uint8)}
    about = "virtual scan: made by a model of a depth-camera scanner, nothing was measured; metres"
    write_ply(folder / "scan.ply", vertex, comments=(about,))
    rounded = [{"scanner_to_world": np.round(pose, 9).tolist()} for pose in poses]
    (folder / "views.json").write_text(
        json.dumps({"virtual": True, "views": rounded}, indent=None, sort_keys=True) + "\n"
    )
    support = moved(staged.support, rng)
    write_ply(
        folder / "support.ply", dict(zip("xyz", support.vertices_m.astype(np.float32).T, strict=True)), support.faces
    )
    np.savez_compressed(
        folder / "truth.npz",
        vertices_m=staged.garment.vertices_m.astype(np.float32),
        faces=staged.garment.faces,
        garment=on_garment,
    )


def thin(points: np.ndarray, cell_m: float, rng: np.random.Generator) -> np.ndarray:
    """Sorted indices of one random point per cell of a grid: scanners fuse their views to a point distance."""
    order = rng.permutation(len(points))
    cells = np.floor(points[order] / cell_m).astype(np.int64)
    cells -= cells.min(axis=0)
    size = cells.max(axis=0) + 1
    _, first = np.unique((cells[:, 0] * size[1] + cells[:, 1]) * size[2] + cells[:, 2], return_index=True)
    return np.sort(order[first])


def moved(shape: Shape, rng: np.random.Generator) -> Shape:
    """The support's own file is never quite where the support stood: some millimetres and a degree off."""
    from scipy.spatial.transform import Rotation

    centre = shape.vertices_m.mean(axis=0)
    turn = Rotation.from_rotvec(rng.normal(0.0, 0.012, 3)).as_matrix()
    return Shape(
        vertices_m=(shape.vertices_m - centre) @ turn.T + centre + rng.normal(0.0, 0.005, 3), faces=shape.faces
    )
