"""Runs Blender in its own process: bpy and pymeshlab bring two versions of one library and crash together."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import sim1
from sim1.progress import report
from sim1.system_libraries import missing_for, remedy

NO_OPENGL = (
    "engine 'workbench' finds no OpenGL; apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri (it needs neither GPU nor "
    "display), or set engine: cycles"
)
TAIL = 2000  # characters of Blender's own words that an error shows


class BlenderFailed(RuntimeError):
    """Blender's process ended before its work was done."""


def why_not_loaded(error: str) -> str:
    """What to do about an import error of bpy: every system library that it lacks, with the packages to install."""
    libraries = missing_for("bpy", error)
    if not libraries:
        return f"Blender cannot be loaded: {error}"
    return f"Blender lacks system libraries: {', '.join(libraries)}; {remedy(libraries)}"


def run_blender(
    job_folder: Path, out: Path, *, command: tuple[str, ...] = (sys.executable, "-m", "sim1.render.worker")
) -> None:
    """Render a job into `out`, reporting progress.

    Args:
        job_folder: written by `sim1.render.job.Job.write`.
        out: the artifact's folder; frames found in it are kept.
        command: the worker.

    Raises:
        BlenderFailed: with the reason, or the last words of Blender.
    """
    path = os.pathsep.join([str(Path(sim1.__file__).parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])])
    failed, broken = None, None
    with tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(
            [*command, str(job_folder), str(out)],
            stdout=subprocess.PIPE,
            stderr=errors,
            stdin=subprocess.DEVNULL,
            text=True,
            env={**os.environ, "PYTHONPATH": path},
        )
        try:
            for line in process.stdout:
                try:
                    message = json.loads(line)
                except ValueError:
                    broken = line
                    break
                if "failed" in message:
                    failed = message["failed"]
                else:
                    report(message["done"], message["total"], message["what"])
        finally:
            if process.poll() is None and (broken or sys.exc_info()[0]):
                process.kill()
            code = process.wait()
            process.stdout.close()
        errors.seek(0)
        words = errors.read().decode(errors="replace")
    if failed is not None:
        raise BlenderFailed(why_not_loaded(failed))
    if broken is not None:
        raise BlenderFailed(
            f"Blender's process says {broken[:200]!r}, which is no progress line; its last words:\n{words[-TAIL:]}"
        )
    if code != 0:
        how = f"was ended by signal {-code}" if code < 0 else f"ended with code {code}"
        if "EGL Error" in words and code < 0:
            how += f": {NO_OPENGL}"
        raise BlenderFailed(f"Blender's process {how}; its last words:\n{words[-TAIL:] or '(none)'}")
