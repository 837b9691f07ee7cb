"""What works on this machine, what is missing, and how to get it. Heavy packages are only imported in processes of their own."""

import functools
import importlib.metadata
import platform
import shutil
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from sim1.progress import report
from sim1.system_libraries import import_error, missing_for, remedy

SET_UP = "run `make setup`"
DISK_GIB = 5.0  # free, for the artifacts of a `make run`
MEMORY_GIB = 8.0  # available; the largest stage takes about half of it
IMPORTS = {  # package -> what must import
    "dagster": "dagster",
    "dagster-webserver": "dagster_webserver",
    "warp-lang": "warp",
    "newton": "newton",
    "mujoco": "mujoco",
    "usd-core": "pxr.Usd",
    "pymeshlab": "pymeshlab",
    "trimesh": "trimesh",
    "bpy": "bpy",
    "torch": "torch",
    "torchvision": "torchvision",
    "lerobot": "lerobot.datasets.lerobot_dataset",
    "scikit-learn": "sklearn",
    "pandas": "pandas",
    "pyarrow": "pyarrow.parquet",
    "scipy": "scipy.optimize",
    "matplotlib": "matplotlib.figure",
    "av": "av",
    "xatlas": "xatlas",
}
GPUS = {  # package -> for what, and code that prints the name of the GPU, "" where there is none
    "torch": ("image policies and Blender", "torch.cuda.get_device_name() if torch.cuda.is_available() else ''"),
}


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """One finding about the machine."""

    name: str
    ok: bool
    detail: str
    remedy: str = ""  # what to do; empty when it is ok
    required: bool = True  # the pipeline does not run without it

    def as_json(self) -> dict[str, Any]:
        return asdict(self)


type Probe = Callable[[], list[Diagnosis]]


def examine(root: Path, *, at_once: int = 2) -> list[Diagnosis]:
    """Examine the machine for the project in `root`, `at_once` probes side by side; takes about 40 s of processor time.

    Progress names the probes under way.
    """
    probes: dict[str, Probe] = {
        "python": lambda: [python_version(sys.version_info[:2], _wanted_python(root))],
        "versions": lambda: [versions(_text(root / "requirements.txt"), _installed())],
        "disk": lambda: [disk(shutil.disk_usage(root).free / 2**30)],
        "memory": lambda: [memory(*_memory_gib())],
        **{name: functools.partial(probe_package, name, module) for name, module in IMPORTS.items()},
    }
    found: dict[str, list[Diagnosis]] = {}
    running: dict[Future[list[Diagnosis]], str] = {}
    waiting = list(probes)
    with ThreadPoolExecutor(at_once) as pool:
        while len(found) < len(probes):
            while waiting and len(running) < at_once:
                name = waiting.pop(0)
                running[pool.submit(probes[name])] = name
            report(len(found), len(probes), ", ".join(running.values()))
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                found[running.pop(future)] = future.result()
    report(len(found), len(probes), "")
    return [diagnosis for name in probes for diagnosis in found[name]]


def healthy(diagnoses: list[Diagnosis]) -> bool:
    """Can the pipeline run here?"""
    return all(diagnosis.ok for diagnosis in diagnoses if diagnosis.required)


def python_version(running: tuple[int, ...], wanted: tuple[int, ...]) -> Diagnosis:
    """Is this the Python that the packages are pinned for?"""
    shown, named = (".".join(str(part) for part in version) for version in (running, wanted))
    ok = running[: len(wanted)] == wanted
    return Diagnosis(
        name="python",
        ok=ok,
        detail=f"Python {shown} on {platform.system()} {platform.machine()}, wanted {named}",
        remedy="" if ok else f"{SET_UP}: it makes .venv with Python {named}",
    )


def versions(requirements: str, installed: Mapping[str, str]) -> Diagnosis:
    """Does what is installed (canonical name -> version) agree with the pinned requirements?"""
    from packaging.requirements import InvalidRequirement, Requirement
    from packaging.utils import canonicalize_name

    pins: dict[str, str] = {}
    for line in requirements.splitlines():
        text = line.strip().rstrip("\\").strip()
        if not text or text.startswith(("#", "--")):
            continue
        try:
            pin = Requirement(text)
        except InvalidRequirement as error:
            return Diagnosis(
                name="versions", ok=False, detail=f"requirements.txt: {text!r}: {error}", remedy="restore the file"
            )
        if pin.marker is None or pin.marker.evaluate():
            pins[canonicalize_name(pin.name)] = str(pin.specifier).removeprefix("==")
    wrong = [
        f"{name} {installed.get(name, 'missing')} (wanted {version})"
        for name, version in sorted(pins.items())
        if installed.get(name) != version
    ]
    ok = bool(pins) and not wrong
    detail = f"{len(pins)} packages as pinned" if ok else "; ".join(wrong[:6]) or "requirements.txt names no package"
    return Diagnosis(name="versions", ok=ok, detail=detail, remedy="" if ok else SET_UP)


def package(name: str, version: str, error: str, missing: list[str]) -> Diagnosis:
    """What an attempt to import a package showed: its last error line ("" when it worked) and missing system libraries."""
    if not error:
        return Diagnosis(name=name, ok=True, detail=version)
    if missing:
        return Diagnosis(
            name=name, ok=False, detail=f"system libraries missing: {', '.join(missing)}", remedy=remedy(missing)
        )
    return Diagnosis(name=name, ok=False, detail=error, remedy=f"{SET_UP}; if it stays, remove .venv first")


def probe_package(name: str, module: str) -> list[Diagnosis]:
    """Import a package in a process of its own and say what came of it; ask it for a GPU where it would use one."""
    purpose, question = GPUS.get(name, ("", "''"))
    error, printed = import_error(f"import {module}; print('GPU:', {question})")
    missing = missing_for(module.partition(".")[0], error) if error else []
    try:
        version = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        version = "version unknown"
    found = [package(name, version, error, missing)]
    if purpose:
        # Libraries print as they please; only what follows the mark is the answer.
        found.append(gpu(f"gpu for {purpose} ({name})", error, printed.rpartition("GPU:")[2].strip()))
    return found


def gpu(name: str, error: str, device: str) -> Diagnosis:
    """A GPU makes the work faster; nothing needs one."""
    if device and not error:
        return Diagnosis(name=name, ok=True, detail=device, required=False)
    return Diagnosis(
        name=name,
        ok=False,
        detail=error or "none found: runs on the CPU",
        remedy="an NVIDIA GPU with its driver, if it is to be faster; not needed",
        required=False,
    )


def disk(free_gib: float) -> Diagnosis:
    """Room for the artifacts."""
    ok = free_gib >= DISK_GIB
    return Diagnosis(
        name="disk",
        ok=ok,
        detail=f"{free_gib:.1f} GiB free, {DISK_GIB:.0f} GiB wanted",
        remedy="" if ok else "free some space, or `sim1 clean` for artifacts that nothing uses",
    )


def memory(available_gib: float, total_gib: float) -> Diagnosis:
    """Room for the largest stage; too little is slow rather than fatal, so it is advice."""
    ok = available_gib >= MEMORY_GIB
    return Diagnosis(
        name="memory",
        ok=ok,
        detail=f"{available_gib:.1f} of {total_gib:.1f} GiB available, {MEMORY_GIB:.0f} GiB wanted",
        remedy="" if ok else "close other programs, or run one garment at a time (sim1 run --garment NAME)",
        required=False,
    )


def _wanted_python(root: Path) -> tuple[int, ...]:
    return tuple(int(part) for part in _text(root / ".python-version").strip().split(".") if part.isdigit())


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8") if path.is_file() else ""


def _installed() -> dict[str, str]:
    from packaging.utils import canonicalize_name

    found = importlib.metadata.distributions()
    return {canonicalize_name(item.metadata["Name"]): item.version for item in found if item.metadata["Name"]}


def _memory_gib() -> tuple[float, float]:
    """Available and total memory; a container's limit counts."""
    fields = dict(line.split(":", 1) for line in _text(Path("/proc/meminfo")).splitlines() if ":" in line)
    available, total = (int(fields.get(key, "0 kB").split()[0]) / 2**20 for key in ("MemAvailable", "MemTotal"))
    limit, used = (_text(Path("/sys/fs/cgroup") / name).strip() for name in ("memory.max", "memory.current"))
    if limit.isdigit() and used.isdigit():
        total = min(total, int(limit) / 2**30)
        available = min(available, (int(limit) - int(used)) / 2**30)
    return available, total
