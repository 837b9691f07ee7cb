"""Thread directions of a sheet: warp and weft as the material axes of its triangles."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import warp as wp

from sim1.cloth.avbd.sheet import Sheet

type Direction = tuple[float, float, float]

WARP: Direction = (
    1.0,
    0.0,
    0.0,
)  # at rest, projected on each face; weft lies a quarter turn further about the face's normal


def warp_of(effects: Iterable[Any]) -> Direction:
    """The one warp direction of a cloth: what an effect asks for, else `WARP`.

    Raises:
        ValueError: two effects ask for different ones.
    """
    asked = {tuple(effect.warp) for effect in effects if effect.warp is not None}
    if len(asked) > 1:
        raise ValueError(f"a cloth has one warp direction, effects ask for {sorted(asked)}")
    return next(iter(asked), WARP)


def align(sheet: Sheet, rest_m: np.ndarray, warp: Direction) -> None:
    """Turn the material axes of every triangle so that the first is the warp; what the sheet does stays the same.

    Raises:
        ValueError: the warp direction stands upright on a face.
    """
    pose = sheet.triangle_pose.numpy().astype(float)
    angle = warp_angle(sheet.triangle.numpy(), pose, rest_m, np.array(warp))
    cosine, sine = np.cos(angle), np.sin(angle)
    axes = np.stack([np.stack([cosine, -sine], axis=-1), np.stack([sine, cosine], axis=-1)], axis=1)
    law = np.stack([turned(one, -a) for one, a in zip(sheet.triangle_law.numpy().astype(float), angle, strict=True)])
    sheet.triangle_pose = wp.array((pose @ axes).astype(np.float32), dtype=wp.mat22)
    sheet.triangle_law = wp.array(law.astype(np.float32), dtype=wp.mat33)


def warp_angle(triangles: np.ndarray, poses: np.ndarray, rest_m: np.ndarray, warp: np.ndarray) -> np.ndarray:
    """Angle (t,) of the warp direction from the first axis of each triangle's material frame [rad].

    Raises:
        ValueError: the warp direction stands upright on a face.
    """
    corners = rest_m[triangles].astype(float)
    edges = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
    axes = edges @ poses.astype(float)  # (t, 3, 2): the material axes in space, at rest
    components = np.einsum("tij,i->tj", axes, warp / np.linalg.norm(warp))
    if (np.linalg.norm(components, axis=1) < 1e-3).any():
        face = int(np.argmin(np.linalg.norm(components, axis=1)))
        raise ValueError(f"the warp direction {warp.tolist()} stands upright on face {face}; give another one")
    return np.arctan2(components[:, 1], components[:, 0])


def turned(law: np.ndarray, angle: float) -> np.ndarray:
    """Law in axes turned by minus `angle`: strain there is T strain, Voigt with engineering shear."""
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
    return turn.T @ law @ turn


def answers_of(corners_m: np.ndarray, warp: Direction) -> np.ndarray:
    """Angles (h, 3) [rad m] of hinges by curvature of the sheet along warp, along weft, and twist; corners (h, 4, 3) at rest.

    The four corners are lifted off the plane of the hinge along its normal by k_u u^2 / 2 + k_v v^2 / 2 + k_uv u v, positive
    towards the normal u x v.
    """
    a, b, c, d = corners_m.swapaxes(0, 1)
    edge = d - c
    first, second = np.cross(c - a, d - a), np.cross(d - b, c - b)
    squares = [np.maximum((n * n).sum(axis=1), 1e-20) for n in (first, second)]
    length_sq = np.maximum((edge * edge).sum(axis=1), 1e-20)
    at_a, at_b = (
        -np.sqrt(length_sq) / np.sqrt(square) for square in squares
    )  # along the normals, as in `elastic.bend`
    ta, tb = (((p - c) * edge).sum(axis=1) / length_sq for p in (a, b))
    at_c, at_d = -(1.0 - ta) * at_a - (1.0 - tb) * at_b, -ta * at_a - tb * at_b
    along, across = _axes(first + second, warp)
    angle = np.zeros((len(corners_m), 3))
    for slope, point in zip((at_a, at_b, at_c, at_d), (a, b, c, d), strict=True):
        away = point - 0.5 * (c + d)
        u, v = (away * along).sum(axis=1), (away * across).sum(axis=1)
        angle += slope[:, None] * np.stack([0.5 * u * u, 0.5 * v * v, u * v], axis=1)
    return angle


def spans_of(corners_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Length (h,) [m] of hinges, and width (h,) [m] over which they turn: bent about it by k, a sheet has the angle k width."""
    a, b, c, d = corners_m.swapaxes(0, 1)
    length = np.maximum(np.linalg.norm(d - c, axis=1), 1e-12)
    areas = [0.5 * np.linalg.norm(np.cross(c - p, d - p), axis=1) for p in (a, b)]
    return length, (areas[0] + areas[1]) / length


def across_of(corners_m: np.ndarray, warp: Direction) -> np.ndarray:
    """Direction (h, 2) across each hinge in the plane, in warp and weft."""
    _a, _b, c, d = corners_m.swapaxes(0, 1)
    normal = _normals(corners_m)
    along, weft = _axes(normal, warp)
    n = np.cross(normal, d - c)
    n /= np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-20)
    return np.stack([(n * along).sum(axis=1), (n * weft).sum(axis=1)], axis=1)


def stretched(corners_m: np.ndarray, factors: tuple[float, float], warp: Direction) -> np.ndarray:
    """Corners of hinges (h, 4, 3) where the sheet is longer by these factors along warp and weft."""
    middle = corners_m.mean(axis=1, keepdims=True)
    moved = corners_m
    for axis, factor in zip(_axes(_normals(corners_m), warp), factors, strict=True):
        moved = moved + (factor - 1.0) * ((corners_m - middle) @ axis[:, :, None]) * axis[:, None, :]
    return moved


def _normals(corners_m: np.ndarray) -> np.ndarray:
    """Twice the areas of the faces of hinges along their normals, (h, 3)."""
    a, b, c, d = corners_m.swapaxes(0, 1)
    return np.cross(c - a, d - a) + np.cross(d - b, c - b)


def _axes(normal: np.ndarray, warp: Direction) -> tuple[np.ndarray, np.ndarray]:
    """Unit warp and weft (h, 3) in planes of these normals."""
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-20)
    unit = np.array(warp) / np.linalg.norm(warp)
    along = unit - (normal @ unit)[:, None] * normal
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-20)
    return along, np.cross(normal, along)


def resized(sheet: Sheet, factors: tuple[float, float]) -> None:
    """Multiply the size at rest along warp and weft of an aligned sheet; mass and stiffness per width stay."""
    pose = sheet.triangle_pose.numpy().astype(float)
    corners = np.linalg.inv(pose)  # columns: edges 0-1 and 0-2 in material axes
    sides = np.stack([corners[:, :, 0], corners[:, :, 1], corners[:, :, 1] - corners[:, :, 0]], axis=1)  # (t, 3, 2)
    ends = sheet.triangle.numpy()[:, [[0, 1], [0, 2], [1, 2]]]  # (t, 3, 2)
    longer = np.linalg.norm(sides * np.array(factors), axis=2) / np.linalg.norm(sides, axis=2)
    ratio = {
        tuple(sorted(map(int, pair))): float(r) for pair, r in zip(ends.reshape(-1, 2), longer.ravel(), strict=True)
    }
    sheet.triangle_pose = wp.array((pose / np.array(factors)).astype(np.float32), dtype=wp.mat22)
    sheet.triangle_area = wp.array(sheet.triangle_area.numpy() * np.float32(factors[0] * factors[1]), dtype=float)
    edges = np.array([ratio[tuple(sorted(map(int, pair)))] for pair in sheet.edge.numpy()], dtype=np.float32)
    sheet.edge_length = wp.array(sheet.edge_length.numpy() * edges, dtype=float)
    hinges = np.array([ratio[tuple(sorted(map(int, pair)))] for pair in sheet.hinge.numpy()[:, 2:]])
    # A hinge of a plate of rigidity D has D L^2 / (A1 + A2), see `sim1.cloth.model.hinge_stiffness`.
    firmer = (hinges**2 / (factors[0] * factors[1])).astype(np.float32)
    sheet.hinge_stiffness = wp.array(sheet.hinge_stiffness.numpy() * firmer, dtype=float)
    sheet.hinge_damping = wp.array(sheet.hinge_damping.numpy() * firmer, dtype=float)
