"""Where the cameras of an episode stood and how they project, as numbers for whoever works with the pictures."""

from typing import Any

from sim1.scene.description import Scene
from sim1.stage import BadInput


def camera_model(name: str, seen_by: dict[str, Any], scene: Scene | None) -> dict[str, Any]:
    """A camera as JSON: `width`, `height`, `fx`, `fy`, `cx`, `cy` [px], `camera_to_world` (4 x 4) and `moves`.

    Pictures are made without distortion, with square pixels and the principal point in the middle; (0, 0) is the upper left
    corner of the upper left pixel. The camera looks along its -z, y up (OpenGL): a point (x, y, z) in its frame is seen at
    (cx - fx x / z, cy + fy y / z). Its pose is the one that was rendered, with the appearance's own elevation.

    A camera on a wrist moves: its pose is that of the first frame, and where a scene is given `link` names what carries it and
    `camera_to_link` (4 x 4) says where.

    Args:
        name: `head`, `left_wrist` or the like.
        seen_by: the camera in `appearance.json`.
        scene: of the garment; None: not known.

    Raises:
        BadInput: the scene has no such camera on a wrist.
    """
    model = {
        "width": seen_by["width"],
        "height": seen_by["height"],
        "fx": seen_by["fy_px"],
        "fy": seen_by["fy_px"],
        "cx": seen_by["width"] / 2,
        "cy": seen_by["height"] / 2,
        "camera_to_world": seen_by["camera_to_world"],
        "moves": seen_by["moves"],
    }
    if not seen_by["moves"] or scene is None:
        return model
    camera = scene.wrist_cameras.get(name.removesuffix("_wrist"))
    if camera is None:
        raise BadInput(
            f"{scene.urdf.parent}/scene.json: wrist_cameras has no {name}, rendered episodes show it; render the episodes again"
        )
    return {**model, "link": camera.link, "camera_to_link": camera.pose.tolist()}
