"""One of Blender's processes: `python -m sim1.render.worker JOB OUT THREADS` renders pictures of the job in the folder JOB.

Takes orders (`sim1.render.shares.Order`) as lines on the standard input until that ends. Says on the standard output, as JSON
lines, on which device it renders once it is ready, {"device"}, and each picture that lies in OUT, {"rendered"}; or why Blender
cannot be loaded, {"failed"}. Blender's own chatter goes to the standard error. No picture is ever half-written.
"""

import json
import os
import signal
import sys
from pathlib import Path

import numpy as np

from sim1.whole_file import whole_file


def main(job_folder: Path, out: Path, threads: int) -> int:
    talk = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # Blender prints to the standard output whatever it is told
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides about Ctrl-C

    def say(**message: object) -> None:
        # Raises BrokenPipeError when the parent is gone, which ends this process as well.
        talk.write(json.dumps(message) + "\n")

    try:
        from sim1.render.scene3d import RenderScene
    except ImportError as error:
        say(failed=str(error))
        return 3
    from sim1.render.job import Job
    from sim1.render.shares import Order

    job = Job.read(job_folder)
    settings = {**job.settings, "threads": threads}
    scene = RenderScene(arrays=job.arrays(), part_colors=job.part_colors, texture=job.texture, settings=settings)
    say(device=scene.device)
    clip, footage = None, None
    for line in sys.stdin:
        order = Order.of(line)
        # Not its key alone: a live camera may be shown another look under the same one.
        if (asked := job.clip(order.clip)) != clip:
            clip = asked
            scene.set_appearance(clip.appearance)
            footage = None if order.moment else job.footage(clip)
        if order.moment:
            footage = job.moment(order.moment)
        for camera, frame in order.pictures:
            at = frame - footage.first
            scene.set_frame(garment_m=footage.garment_m[at], parts=footage.parts[at])
            path = job.frame_path(out, clip, camera, frame)
            path.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(path) as part:
                scene.render(
                    part,
                    camera_to_world=footage.cameras[camera][at],
                    fy_over_height=job.fy_over_height[camera],
                    seed=job.picture_seed(clip, camera, frame),
                )
                _keep_pixels_only(part)
            say(rendered=path.relative_to(out).as_posix())
    return 0


def _keep_pixels_only(path: Path) -> None:
    """Drop Cycles' notes from a PNG file: they tell how long the rendering took, different every time."""
    from PIL import Image

    with Image.open(path, formats=["PNG"]) as image:
        pixels = image.convert("RGB")
    pixels.save(path, format="PNG")


if __name__ == "__main__":
    np.seterr(all="raise", under="ignore")
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3])))
