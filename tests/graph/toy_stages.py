"""Stages that do next to nothing, for tests of the graph: the artifact is a digest of what went in."""

import hashlib
import os
import time
from pathlib import Path
from typing import Any

from sim1.progress import track
from sim1.stage import BadInput, Facts, Finding, Inputs


def ingest(inputs: Inputs, out: Path, config: dict[str, Any]) -> Facts:
    """Read a garment's text files without their comments: a comment-only edit gives the same artifact."""
    lines = []
    for name in sorted(inputs):
        for path in inputs[name].values():
            for file in sorted([path] if path.is_file() else path.rglob("*")):
                lines += [line for line in file.read_text().splitlines() if line and not line.startswith("#")]
    if "bad" in lines:
        raise BadInput("scan.txt: line 1: bad (got 'bad'); write something else")
    (out / "content.txt").write_text("\n".join(lines))
    return {"lines": len(lines)}


def check_source_garment(path: Path) -> None:
    """Refuses a garment file that says `broken`."""
    if "broken" in path.read_text():
        raise BadInput(f"{path}: key 'broken' is unknown")


def work(inputs: Inputs, out: Path, config: dict[str, Any]) -> Facts:
    """Digest of all inputs and the config; config keys `sleep_s`, `die_unless`, `invalid`, `odd`, `no_space` and `raises` act as they say."""
    digest = hashlib.sha256(repr(sorted((config or {}).items())).encode())
    for name in sorted(set(inputs) - {"timings"}):
        for garment, path in sorted(inputs[name].items()):
            digest.update(f"{name}/{garment}".encode())
            for file in sorted([path] if path.is_file() else path.rglob("*.txt")):
                digest.update(file.read_bytes())
    for _ in track(range(int(config.get("sleep_s", 0) * 20)), "sleeping"):
        time.sleep(0.05)
    if (marker := config.get("die_unless")) and not Path(marker).exists():
        os.kill(os.getpid(), 9)
    if config.get("raises"):
        raise RuntimeError(f"{out}: the library has a fault")
    if config.get("no_space"):
        raise OSError(28, "No space left on device", str(out / "content.txt"))
    marks = "".join(f"\n{mark}" for mark in ("invalid", "odd") if config.get(mark))
    (out / "content.txt").write_text(digest.hexdigest() + marks)
    return {"inputs": sum(map(len, inputs.values()))}


def frames(inputs: Inputs, out: Path, config: dict[str, Any]) -> Facts:
    """Write four files, those that are not there yet; killed after two of them unless the file `die_unless` exists."""
    written = 0
    for number in range(4):
        if not (file := out / f"{number}.txt").exists():
            file.write_text(str(number))
            written += 1
        time.sleep(config.get("sleep_s", 0.0))
        if number == 1 and not Path(config["die_unless"]).exists():
            if config.get("raises"):
                raise BadInput("interrupted")
            os.kill(os.getpid(), 9)
    return {"written": written}


def pages(inputs: Inputs, out: Path, config: dict[str, Any]) -> Facts:
    """A page for every line of the source `book`; pages that are there already are kept, others than those are removed."""
    (book,) = inputs["book"].values()
    wanted = {f"{line}.txt": line for line in book.read_text().split()}
    there = {file.name for file in out.iterdir()}
    for name in there - set(wanted):
        (out / name).unlink()
    for name in set(wanted) - there:
        (out / name).write_text(wanted[name])
    if (marker := config.get("die_unless")) and not Path(marker).exists():
        os.kill(os.getpid(), 9)
    return {"written": len(set(wanted) - there)}


def check_model(artifact: Path) -> list[Finding]:
    """Blocks a book with the word `invalid`."""
    return check_mesh(artifact)[:1]


def check_mesh(artifact: Path) -> list[Finding]:
    """Blocks an artifact that says it is invalid, warns of one that says it is odd."""
    text = "".join(file.read_text() for file in sorted(artifact.glob("*.txt")))
    return [
        Finding(name="is_valid", passed="invalid" not in text, detail=f"{len(text)} characters"),
        Finding(name="is_even", passed="odd" not in text, detail="an odd artifact; look at it", blocking=False),
    ]
