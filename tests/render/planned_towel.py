"""What would be rendered of the small towel, and stand-ins for its frames."""

import io
from pathlib import Path

import numpy as np
from PIL import Image

from sim1.render.plan import drawn, plan_job
from sim1.render.stage import RenderConfig

CONFIG = RenderConfig(width=48, height=36, samples=2, rate_hz=15, variants=2, workers=1, threads=1, device="cpu")


def png(width: int, height: int, gray: int = 0) -> bytes:
    """A picture of noise, or of one grey."""
    pixels = (
        np.random.default_rng(0).integers(60, 200, (height, width, 3))
        if not gray
        else np.full((height, width, 3), gray)
    )
    file = io.BytesIO()
    Image.fromarray(pixels.astype(np.uint8)).save(file, format="PNG")
    return file.getvalue()


FRAME = png(48, 36)  # stands for one that was rendered


def plan(inputs, out: Path, config: RenderConfig, garment: str = "towel"):
    """What would be rendered, without Blender; the towel under that name."""
    out.mkdir(exist_ok=True)
    return plan_job(
        trajectories=inputs["valid_trajectories"]["towel"],
        mesh=inputs["garment_mesh"]["towel"],
        scene=inputs["scene"]["towel"],
        choice=drawn(inputs["appearance"]["towel"], "towel", config, {}),
        garment=garment,
        out=out,
        folder=out.with_suffix(".job"),
        config=config,
    )


def with_frames(out: Path, job) -> dict[str, Path]:
    """A stand-in for the first frame of every clip: clip -> file."""
    files = {}
    for clip in job.clips:
        files[clip.key] = job.frame_path(out, clip, "head", 0)
        files[clip.key].parent.mkdir(parents=True, exist_ok=True)
        files[clip.key].write_bytes(FRAME)
    return files
