"""Which Debian or Ubuntu package brings a shared library that a Python package wants. Standard library alone."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

NEEDING = ("bpy", "pymeshlab")  # Python packages that want libraries of the system
PACKAGES = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libGLU.so.1": "libglu1-mesa",
    "libGLX.so.0": "libglx0",
    "libGLdispatch.so.0": "libglvnd0",
    "libICE.so.6": "libice6",
    "libOpenGL.so.0": "libopengl0",
    "libSM.so.6": "libsm6",
    "libX11.so.6": "libx11-6",
    "libX11-xcb.so.1": "libx11-xcb1",
    "libXau.so.6": "libxau6",
    "libXcursor.so.1": "libxcursor1",
    "libXdmcp.so.6": "libxdmcp6",
    "libXext.so.6": "libxext6",
    "libXfixes.so.3": "libxfixes3",
    "libXi.so.6": "libxi6",
    "libXinerama.so.1": "libxinerama1",
    "libXrandr.so.2": "libxrandr2",
    "libXrender.so.1": "libxrender1",
    "libXt.so.6": "libxt6",
    "libXxf86vm.so.1": "libxxf86vm1",
    "libdbus-1.so.3": "libdbus-1-3",
    "libfontconfig.so.1": "libfontconfig1",
    "libfreetype.so.6": "libfreetype6",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libgomp.so.1": "libgomp1",
    "libgthread-2.0.so.0": "libglib2.0-0",
    "libstdc++.so.6": "libstdc++6",
    "libuuid.so.1": "libuuid1",
    "libwayland-client.so.0": "libwayland-client0",
    "libxcb.so.1": "libxcb1",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libz.so.1": "zlib1g",
}
_ABSENT = re.compile(r"(lib[\w+.-]+\.so[\w.]*): cannot open shared object file")
_NOT_FOUND = re.compile(r"^\s*(lib\S+) => not found", re.MULTILINE)


def absent_libraries(text: str) -> list[str]:
    """Names of shared libraries that an import error or the output of `ldd` calls missing, in order of name."""
    return sorted({*_ABSENT.findall(text), *_NOT_FOUND.findall(text)})


def remedy(libraries: list[str]) -> str:
    """What to type to get the libraries; names those whose package is not known."""
    packages = sorted({PACKAGES[name] for name in libraries if name in PACKAGES})
    unknown = [name for name in libraries if name not in PACKAGES]
    words = [f"apt-get install {' '.join(packages)}"] if packages else []
    if unknown:
        words.append(f"find the package of {', '.join(unknown)} (apt-file search {unknown[0]})")
    return "; ".join(words)


def import_error(code: str, *, python: str = sys.executable, limit_s: float = 240.0) -> tuple[str, str]:
    """Run `code` (an import, at its simplest) in a process of its own.

    Returns:
        The error's last lines, "" when it worked, and what the code printed.
    """
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONWARNINGS": "ignore"}
    try:
        done = subprocess.run(
            [python, "-c", code], capture_output=True, text=True, timeout=limit_s, env=environment, check=False
        )
    except subprocess.TimeoutExpired:
        return f"did not answer within {limit_s:.0f} s", ""
    if done.returncode == 0:
        return "", done.stdout.strip()
    last = done.stderr.strip().splitlines()[-1:] or [f"ended by signal or exit code {done.returncode}"]
    return last[0], done.stdout.strip()


def missing_for(package: str, error: str) -> list[str]:
    """Every shared library that `package` lacks: the one that its import `error` names, and the others that `ldd` finds."""
    text = error
    spec = importlib.util.find_spec(package)
    if spec is not None and spec.origin and (ldd := shutil.which("ldd")):
        for library in sorted(Path(spec.origin).parent.glob("*.so")):
            done = subprocess.run([ldd, str(library)], capture_output=True, text=True, timeout=60, check=False)
            text += "\n" + done.stdout
    return absent_libraries(text)
