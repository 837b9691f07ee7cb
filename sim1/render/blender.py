"""Runs Blender in processes of its own: bpy and pymeshlab bring two versions of one library and crash together.

One per core with a thread each, rather than one with all threads: small frames hold little that threads can share.
"""

import json
import os
import signal
import sys
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from sim1.progress import report
from sim1.render.appearance_file import note_device
from sim1.render.blender_process import BlenderProcess, Said
from sim1.render.job import Job
from sim1.render.shares import Shares
from sim1.system_libraries import missing_for, remedy

NO_OPENGL = (
    "engine 'workbench' finds no OpenGL; apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri (it needs neither GPU nor "
    "display), or set engine: cycles"
)
KILLED = "where memory ran out, set workers of rendered_episodes lower (of image_trials: processes), or give it fewer cores: taskset -c 0-3 sim1 ..."
TAIL = 2000  # characters of Blender's own words that an error shows


class BlenderFailed(RuntimeError):
    """A process of Blender ended before its work was done."""


def why_not_loaded(error: str) -> str:
    """What to do about an import error of bpy: every system library that it lacks, with the packages to install."""
    libraries = missing_for("bpy", error)
    if not libraries:
        return f"Blender cannot be loaded: {error}"
    return f"Blender lacks system libraries: {', '.join(libraries)}; {remedy(libraries)}"


def run_blender(
    job_folder: Path, out: Path, *, command: tuple[str, ...] = (sys.executable, "-m", "sim1.render.worker")
) -> None:
    """Render a job into `out`, reporting progress. How many processes and threads do it has no influence on the frames.

    Args:
        job_folder: written by `sim1.render.job.Job.write`.
        out: the artifact's folder; frames found in it are kept.
        command: a worker.

    Raises:
        BlenderFailed: with the reason, or the last words of the process that failed; the others are ended.
    """
    job = Job.read(job_folder)
    missing = job.missing(out)
    total, left = job.frame_count, sum(map(len, missing.values()))
    report(total - left, total, "frames")
    shares, clips = Shares(missing), {clip.key: clip for clip in job.clips}
    workers, threads = crew_size(job.settings, shares.batches, os.process_cpu_count() or 1)
    said: SimpleQueue[Said] = SimpleQueue()
    crew: list[BlenderProcess] = []
    try:
        for _ in range(workers):
            crew.append(BlenderProcess([*command, str(job_folder), str(out), str(threads)], said))
        at_work = set(crew)
        while at_work:
            worker, line = said.get()
            if line is None:
                check_end(worker)
                at_work.remove(worker)
                continue
            if tells_of_a_picture(worker, line):
                left -= 1
                report(total - left, total, "frames")
            if worker.owed:
                continue
            # One process keeps a GPU busy, and each takes a part of its memory.
            spare = worker.device == "gpu" and not job.settings["workers"] and worker is not crew[0]
            if spare or not (order := shares.take(worker.clip)):
                worker.dismiss()
                continue
            if order.clip != worker.clip:
                note_device(out / clips[order.clip].folder, worker.device)
            worker.send(order)
    finally:
        for worker in crew:
            worker.kill()
        for worker in crew:
            worker.close()


def crew_size(settings: dict[str, Any], batches: int, cores: int) -> tuple[int, int]:
    """Number of workers, and of threads of each: a worker per core unless there is less to do, and all cores shared out."""
    workers = min(settings["workers"] or cores, batches)
    return workers, settings["threads"] or max(1, cores // max(1, workers))


def tells_of_a_picture(worker: BlenderProcess, line: str) -> bool:
    """Whether a line says that a picture is rendered, rather than that the process is ready; what it says is kept with it.

    Raises:
        BlenderFailed: the line says why Blender cannot be loaded, or was not meant for us.
    """
    match _json(line):
        case {"rendered": _}:
            worker.owed -= 1
            return True
        case {"device": device}:
            worker.device = device
            return False
        case {"failed": error}:
            raise BlenderFailed(why_not_loaded(error))
    worker.kill()
    _, words = worker.ended()
    raise BlenderFailed(
        f"Blender's process says {line[:200]!r}, which is no progress line; its last words:\n{words[-TAIL:]}"
    )


def _json(line: str) -> Any:
    try:
        return json.loads(line)
    except ValueError:
        return None


def check_end(worker: BlenderProcess) -> None:
    """Raises BlenderFailed at a process that ended by accident, or before it was told to."""
    code, words = worker.ended()
    if code == 0 and worker.dismissed:
        return
    how = f"was ended by signal {-code}" if code < 0 else f"ended with code {code}"
    if code == -signal.SIGKILL:
        how += f" ({KILLED})"
    if "EGL Error" in words and code < 0:
        how += f": {NO_OPENGL}"
    raise BlenderFailed(f"Blender's process {how}; its last words:\n{words[-TAIL:] or '(none)'}")
