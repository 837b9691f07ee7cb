"""Pinhole cameras: poses about the table and projection, OpenGL convention (looks along -z, y up)."""

import numpy as np

from sim1.stage import BadInput


def raised(camera_to_world: np.ndarray, elevation_rad: float, *, what: str = "camera") -> np.ndarray:
    """Move a camera on a circle about the world's origin, the middle of the table, by an angle of elevation.

    The camera turns with the move, so the table stays where it is in the picture.

    Args:
        camera_to_world: (4, 4).
        elevation_rad: positive moves the camera up.
        what: file and camera, for the message.

    Raises:
        BadInput: the camera stands straight above the origin, where elevation has no direction, and is to be moved.
    """
    if elevation_rad == 0.0:
        return camera_to_world
    x, y, _ = camera_to_world[:3, 3]
    reach = np.hypot(x, y)
    if reach < 1e-6:
        place = ", ".join(f"{value:g}" for value in camera_to_world[:3, 3])
        raise BadInput(
            f"{what} at ({place}) m stands straight above the table's middle, where elevation has no direction; set "
            "elevation_jitter_deg of rendered_episodes to 0, shifted_trajectories of image_policy and trial_count of image_trials to 0, or move the camera in "
            "data/environment"
        )
    # Rotation by a positive angle about this horizontal axis lowers what stands on the camera's side, hence the sign.
    ax, ay = -y / reach, x / reach
    sin, cos = np.sin(-elevation_rad), np.cos(elevation_rad)
    rotation = np.array(
        [
            [cos + ax * ax * (1 - cos), ax * ay * (1 - cos), ay * sin, 0.0],
            [ax * ay * (1 - cos), cos + ay * ay * (1 - cos), -ax * sin, 0.0],
            [-ay * sin, ax * sin, cos, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
    return rotation @ camera_to_world


def project(
    points_m: np.ndarray, *, camera_to_world: np.ndarray, fy_over_height: float, width: int, height: int
) -> tuple[np.ndarray, np.ndarray]:
    """Pixel coordinates (n, 2), x right and y down, and depth [m] (n,) of points (n, 3) in the world frame."""
    local = (points_m - camera_to_world[:3, 3]) @ camera_to_world[:3, :3]
    depth_m = -local[:, 2]
    safe = np.where(depth_m > 1e-3, depth_m, np.inf)
    focal_px = fy_over_height * height
    pixels = np.stack([width / 2 + focal_px * local[:, 0] / safe, height / 2 - focal_px * local[:, 1] / safe], axis=-1)
    return pixels, depth_m
