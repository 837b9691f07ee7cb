"""Blender's process: `python -m sim1.render.worker JOB OUT` renders the job that `sim1.render.job` wrote.

Speaks JSON lines on the standard output ({"done", "total", "what"}, or {"failed"}); Blender's own chatter goes to the
standard error. A frame that is there already is not rendered again, and none is ever half-written.
"""

import json
import os
import sys
from pathlib import Path

import numpy as np


def main(job_folder: Path, out: Path) -> int:
    talk = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # Blender prints to the standard output whatever it is told

    def say(**message: object) -> None:
        # Raises BrokenPipeError when the parent is gone, which ends this process as well.
        talk.write(json.dumps(message) + "\n")

    try:
        from sim1.render.scene3d import RenderScene
    except ImportError as error:
        say(failed=str(error))
        return 3
    from sim1.render.appearance_file import note_device
    from sim1.render.job import Job

    job = Job.read(job_folder)
    missing = [
        (clip, camera, frame)
        for clip, camera, frame in job.frames()
        if not job.frame_path(out, clip, camera, frame).exists()
    ]
    total = job.frame_count
    done = total - len(missing)
    say(done=done, total=total, what="frames")
    if not missing:
        return 0
    scene = RenderScene(arrays=job.arrays(), part_colors=job.part_colors, texture=job.texture, settings=job.settings)
    shown, motion, poses = None, {}, {}
    for clip, camera, frame in missing:
        if clip is not shown:
            scene.set_appearance(clip.appearance)
            motion, poses, shown = job.motion(clip), job.camera_poses(clip), clip
            note_device(out / clip.folder, scene.device)
        scene.set_frame(garment_m=motion["garment_m"][frame], parts=motion["parts"][frame])
        path = job.frame_path(out, clip, camera, frame)
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_name(path.name + ".part")
        scene.render(
            part,
            camera_to_world=poses[camera][frame],
            fy_over_height=job.fy_over_height[camera],
            seed=job.picture_seed(clip, camera, frame),
        )
        _keep_pixels_only(part)
        os.replace(part, path)
        done += 1
        say(done=done, total=total, what="frames")
    return 0


def _keep_pixels_only(path: Path) -> None:
    """Drop Cycles' notes from a PNG file: they tell how long the rendering took, different every time."""
    from PIL import Image

    with Image.open(path, formats=["PNG"]) as image:
        pixels = image.convert("RGB")
    pixels.save(path, format="PNG")


if __name__ == "__main__":
    np.seterr(all="raise", under="ignore")
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
