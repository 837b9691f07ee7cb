"""Looks that a policy was trained on, and how their frames were rendered."""

from pathlib import Path
from typing import Any

from sim1.render.appearance_file import NAME, RENDERED_ON, read_about
from sim1.render.stage import RenderConfig


def about_clip(rendered: Path, trajectory: str, appearance: int) -> dict[str, Any]:
    """What `rendered_episodes` noted of one of its clips.

    Raises:
        BadInput: not readable, or of another schema.
    """
    return read_about(rendered / "episodes" / trajectory / f"v{appearance}" / NAME)


def rendered_like(about: dict[str, Any], stride: int = 1) -> RenderConfig:
    """Settings of stage `rendered_episodes` as a clip's record tells them, engine and noise included."""
    sizes = {(camera["width"], camera["height"]) for camera in about["cameras"].values()}
    # What "auto" found then is taken again: a CPU gives the same picture to the bit.
    device = "cpu" if about[RENDERED_ON] == ["cpu"] else about["device"]
    width, height = sizes.pop()  # one size for all cameras: `RenderConfig` has no other
    return RenderConfig(
        **{key: about[key] for key in ("engine", "seed", "samples", "denoise", "elevation_jitter_deg")},
        device=device,
        rate_hz=about["rate_hz"] // stride,
        cameras=tuple(about["cameras"]),
        width=width,
        height=height,
    )
