"""Pictures of a garment mesh: shaded preview, error map, scan before and after."""

from pathlib import Path

import numpy as np

from sim1.picture_file import save_figure
from sim1.scan.cloud import Shape
from sim1.scan.surface import cast_rays

_PIXELS = 420  # height of a view


def draw_preview(mesh: Shape, title: str, path: Path) -> None:
    """Shaded mesh with its edges, from the front and from behind (a lying garment: from above)."""
    figure = _figure(title)
    sides = _sides(mesh)
    for place, (name, right, up) in enumerate(sides, 1):
        axes = figure.add_subplot(1, len(sides), place)
        face, weights, extent, ray = _seen(mesh, right, up)
        corners = mesh.vertices_m[mesh.faces].astype(float)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        hit = face >= 0
        front = -(normal[face] @ ray)
        light = np.abs(normal[face] @ ((-ray + 0.6 * up - 0.5 * right) / 1.28))
        outside, inside = np.array([0.36, 0.58, 0.78]), np.array([0.85, 0.50, 0.35])
        image = np.where((front > 0)[..., None], outside, inside) * (0.35 + 0.65 * light)[..., None]
        # An edge is where the smallest barycentric weight, as a height above the edge, is below 0.4 mm.
        heights = weights * _heights(corners)[face]
        image = np.where((heights.min(axis=-1) < 7e-4)[..., None], image * 0.45, image)
        axes.imshow(np.where(hit[..., None], image, 1.0).clip(0, 1), extent=extent, interpolation="antialiased")
        _label(axes, name, right, up)
    figure.supxlabel("blue: outside, orange: inside of the fabric", fontsize=8)
    save_figure(figure, path)


def draw_errors(
    mesh: Shape, points: np.ndarray, normals: np.ndarray, distance_m: np.ndarray, title: str, path: Path
) -> None:
    """RMS distance (mm) of the scan points to the mesh, in small cells, on the two sides of the garment."""
    figure = _figure(title)
    limit = max(float(np.percentile(distance_m, 97)) * 1e3, 0.05)
    all_axes = []
    sides = _sides(mesh)
    for place, (name, right, up) in enumerate(sides, 1):
        axes = figure.add_subplot(1, len(sides), place)
        facing = normals @ np.cross(right, up) > 0
        drawn = axes.hexbin(
            points[facing] @ right, points[facing] @ up, distance_m[facing] * 1e3, gridsize=90,
            reduce_C_function=_rms, vmin=0, vmax=limit, cmap="viridis", linewidths=0,
        )  # fmt: skip
        axes.set_aspect("equal")
        _label(axes, name, right, up)
        all_axes.append(axes)
    figure.colorbar(drawn, ax=all_axes, label="RMS distance of scan points to the mesh (mm)", shrink=0.8)
    save_figure(figure, path)


def _rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def draw_separation(points: np.ndarray, garment: np.ndarray, mesh: Shape, title: str, path: Path) -> None:
    """Left: the scan, the garment's points and what was taken for the support. Right: the rims of the mesh."""
    from sim1.scan.rims import rim_edges

    figure = _figure(title)
    name, right, up = _sides(mesh)[0]
    axes = figure.add_subplot(1, 2, 1)
    step = max(1, len(points) // 40_000)
    order = np.argsort(points[::step] @ np.cross(right, up))
    color = np.where(garment[::step][order][:, None], (0.2, 0.45, 0.75), (0.88, 0.62, 0.42))
    axes.scatter(points[::step][order] @ right, points[::step][order] @ up, c=color, s=1.0, lw=0)
    axes.set_aspect("equal")
    _label(axes, f"scan, {name}: garment blue, support orange", right, up)
    axes = figure.add_subplot(1, 2, 2, sharex=axes, sharey=axes)
    vertices = mesh.vertices_m
    lines = vertices[mesh.faces[:, [0, 1, 2, 0]]]
    axes.plot(*_broken(lines @ right, lines @ up), color="0.8", lw=0.3)
    rims = vertices[rim_edges(mesh.faces)]
    axes.plot(*_broken(rims @ right, rims @ up), color="tab:red", lw=1.5)
    axes.set_aspect("equal")
    _label(axes, f"mesh, {name}: openings red", right, up)
    save_figure(figure, path)


def _figure(title: str):
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 4.8), dpi=90, layout="constrained")
    figure.suptitle(title, fontsize=10)
    return figure


def _label(axes, name: str, right: np.ndarray, up: np.ndarray) -> None:
    names = [f"{'-' if axis.sum() < 0 else ''}{'xyz'[int(np.abs(axis).argmax())]} (m)" for axis in (right, up)]
    axes.set_title(name, fontsize=9)
    axes.set(xlabel=names[0], ylabel=names[1])


def _sides(mesh: Shape) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Name, right and up of two views: front and back of a worn garment, top and front of a lying one."""
    size = np.ptp(mesh.vertices_m, axis=0)
    x, y, z = np.eye(3)
    if size[2] < 0.3 * size[:2].min():
        return [("from above", x, y)]
    return [("from the front", y, z), ("from behind", -y, z)]


def _seen(mesh: Shape, right: np.ndarray, up: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[float], np.ndarray]:
    """Orthographic view: face and barycentric weights per pixel, extent for imshow, ray direction."""
    toward = np.cross(right, up)
    across, high = mesh.vertices_m @ right, mesh.vertices_m @ up
    margin = 0.03 * max(np.ptp(across), np.ptp(high))
    low, top = np.array([across.min(), high.min()]) - margin, np.array([across.max(), high.max()]) + margin
    width = int(_PIXELS * (top[0] - low[0]) / (top[1] - low[1]))
    a, b = np.meshgrid(np.linspace(low[0], top[0], width), np.linspace(top[1], low[1], _PIXELS))
    start = a[..., None] * right + b[..., None] * up + (float((mesh.vertices_m @ toward).max()) + 0.1) * toward
    ray = np.broadcast_to(-toward, start.shape)
    distance, face = cast_rays(start.reshape(-1, 3), ray.reshape(-1, 3), mesh.vertices_m, mesh.faces)
    hits = start.reshape(-1, 3) + np.where(face >= 0, distance, 0.0)[:, None] * ray.reshape(-1, 3)
    corners = mesh.vertices_m[mesh.faces[face]].astype(float)
    total = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    parts = [np.cross(corners[:, (k + 1) % 3] - hits, corners[:, (k + 2) % 3] - hits) for k in range(3)]
    weights = np.stack([(part * total).sum(axis=1) / (total**2).sum(axis=1) for part in parts], axis=-1)
    shape = start.shape[:2]
    return face.reshape(shape), weights.reshape(*shape, 3), [low[0], top[0], low[1], top[1]], -toward


def _heights(corners: np.ndarray) -> np.ndarray:
    """Heights (f, 3) of the triangles above the edge opposite to each corner, m."""
    double = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.stack(
        [double / np.linalg.norm(corners[:, (k + 2) % 3] - corners[:, (k + 1) % 3], axis=1) for k in range(3)], axis=1
    )


def _broken(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Polylines (n, k) as one line with gaps, which draws a hundred times faster."""
    gap = np.full((len(x), 1), np.nan)
    return np.concatenate([x, gap], axis=1).ravel(), np.concatenate([y, gap], axis=1).ravel()
