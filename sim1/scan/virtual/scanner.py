"""Model of a hand-held structured-light scanner: a projector and a camera, seen from a number of poses."""

from dataclasses import dataclass

import numpy as np

from sim1.scan.surface import cast_rays


@dataclass(frozen=True, kw_only=True)
class Scanner:
    """Figures of a mid-range structured-light scanner; see its noise in `look`."""

    width: int = 320  # pixels
    height: int = 320
    view_rad: float = 0.75  # field of view, both ways
    baseline_m: float = 0.12  # camera to projector; what the projector does not light is not seen
    noise_m: float = 1.0e-4  # standard deviation along the ray at 0.6 m, facing the scanner
    noise_most_m: float = 3.0e-4
    registration_m: float = 3.0e-5  # standard deviation of a view's position after the scanner's own registration
    grazing_rad: float = 1.22  # beyond this incidence nothing returns; from 0.75 of it on, ever less
    speckle: float = 0.01  # share of the pixels lost to nothing in particular


@dataclass(frozen=True, kw_only=True)
class View:
    """What one pose gives."""

    points_m: np.ndarray  # (n, 3) world frame
    face: np.ndarray  # (n,) face hit
    exact_m: np.ndarray  # (n, 3) without noise


def look_at(eye: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Pose (4, 4) of a scanner at `eye` that looks along its -z at `target`, y up (x where that is not defined)."""
    back = (eye - target) / np.linalg.norm(eye - target)
    up = np.array([0.0, 0.0, 1.0]) if abs(back[2]) < 0.95 else np.array([1.0, 0.0, 0.0])
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, np.cross(back, right), back], axis=1)
    pose[:3, 3] = eye
    return pose


def look(scanner: Scanner, pose: np.ndarray, vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> View:
    """Scan a mesh from one pose.

    Noise along the ray: `noise_m` (distance / 0.6 m)^2 / cos(incidence), at most `noise_most_m`; the square law of
    triangulation.
    """
    side = np.tan(scanner.view_rad / 2)
    pixel = 2 * side / np.array([scanner.width, scanner.height])
    grid = np.stack(
        np.meshgrid(np.linspace(-side, side, scanner.width), np.linspace(-side, side, scanner.height)), axis=-1
    )
    grid = grid.reshape(-1, 2) + rng.uniform(-0.5, 0.5, (scanner.width * scanner.height, 2)) * pixel  # the hand shakes
    ray = np.concatenate([grid, -np.ones((len(grid), 1))], axis=1)
    ray = ray / np.linalg.norm(ray, axis=1, keepdims=True) @ pose[:3, :3].T
    eye = np.broadcast_to(pose[:3, 3], ray.shape)
    distance, face = cast_rays(eye, ray, vertices, faces)
    ray, distance, face, eye = (array[face >= 0] for array in (ray, distance, face, eye))
    exact = eye + distance[:, None] * ray

    corners = vertices[faces[face]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    facing = np.abs((normal * ray).sum(axis=1))

    projector = pose[:3, 3] + scanner.baseline_m * pose[:3, 0]
    light = exact - projector
    reach = np.linalg.norm(light, axis=1)
    lit_at, _ = cast_rays(np.broadcast_to(projector, light.shape), light / reach[:, None], vertices, faces)
    incidence = np.arccos(np.clip(facing, 0.0, 1.0)) / scanner.grazing_rad
    returned = rng.uniform(size=len(exact)) < np.clip((1.0 - incidence) / 0.25, 0.0, 1.0 - scanner.speckle)
    seen = (lit_at > reach - 1e-3) & returned

    spread = np.minimum(scanner.noise_m * (distance / 0.6) ** 2 / np.maximum(facing, 0.1), scanner.noise_most_m)
    noisy = exact + (rng.normal(size=len(exact)) * spread)[:, None] * ray + rng.normal(0.0, scanner.registration_m, 3)
    return View(points_m=noisy[seen], face=face[seen], exact_m=exact[seen])
