"""Runs Blender in its own process: bpy and pymeshlab bring two versions of one library and crash together."""

import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import sim1
from sim1.progress import report

TAIL = 2000  # characters of Blender's own words that an error shows

DEBIAN_PACKAGES = {
    "libX11.so.6": "libx11-6",
    "libXrender.so.1": "libxrender1",
    "libXxf86vm.so.1": "libxxf86vm1",
    "libXfixes.so.3": "libxfixes3",
    "libXi.so.6": "libxi6",
    "libXext.so.6": "libxext6",
    "libXt.so.6": "libxt6",
    "libSM.so.6": "libsm6",
    "libICE.so.6": "libice6",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libgomp.so.1": "libgomp1",
}


class BlenderFailed(RuntimeError):
    """Blender's process ended before its work was done."""


def missing_library(message: str) -> str | None:
    """What to install where `message` says that a shared library is missing, or None."""
    found = re.search(r"(lib\S+?\.so[.\d]*): cannot open shared object file", message)
    if found is None:
        return None
    library = found[1]
    package = DEBIAN_PACKAGES.get(library)
    how = f"apt-get install {package}" if package else f"find its package with: apt-file search {library}"
    return f"Blender needs the system library {library}; {how}"


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
        raise BlenderFailed(missing_library(failed) or f"Blender cannot be loaded: {failed}")
    if broken is not None:
        raise BlenderFailed(
            f"Blender's process says {broken[:200]!r}, which is no progress line; its last words:\n{words[-TAIL:]}"
        )
    if code != 0:
        how = f"was ended by signal {-code}" if code < 0 else f"ended with code {code}"
        raise BlenderFailed(f"Blender's process {how}; its last words:\n{words[-TAIL:] or '(none)'}")
