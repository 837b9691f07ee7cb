"""Make one artifact: gather verified inputs, run the stage, check what it made, put it in place."""

import errno
import json
import os
import shutil
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from assets_defs._config import check_function, config_of, stage_function
from assets_defs._digest import RECORD, digest_file, digest_json
from assets_defs._recipe import Key, Snapshot, label
from assets_defs._sources import source
from assets_defs._store import Place, StoreError, place, verified
from pipeline import Home, Node
from sim1 import progress
from sim1.stage import BadInput, Finding


@dataclass(frozen=True)
class Made:
    """An artifact in its place."""

    path: Path
    record: dict[str, Any]  # recipe, parts, facts, findings, seconds, data_version, files
    findings: list[Finding]


class NotMade(RuntimeError):
    """No artifact was made, and the one before it, if any, is untouched; the message leaves it to others to name it.

    `findings` are set when a check failed.
    """

    def __init__(self, message: str, *, findings: list[Finding] = (), transient: bool = False):
        super().__init__(message)
        self.findings = list(findings)
        self.transient = transient  # worth another try as it is


def produce(home: Home, snapshot: Snapshot, node: Node, key: Key, sink: progress.Sink) -> Made:
    """Make the artifact of `node` for garment `key` in the store.

    Raises:
        NotMade: an input is missing, damaged or wrong, the stage failed, or its artifact failed a blocking check.
    """
    at = place(home, node, key)
    # Taken before the work starts: an input that changes meanwhile leaves the result stale, never falsely fresh.
    parts = snapshot.parts(node, key)
    if parts is None:
        raise NotMade(f"{snapshot.status(node, key).why}; run it first: sim1 run")
    recipe = digest_json(parts)
    try:
        with at.locked():
            try:
                return _produce(home, snapshot, node, key, sink, parts, recipe)
            except NotMade as error:
                at.fail(recipe, str(error))
                raise
            except StoreError:  # of an input, which is made again; nothing is known against this recipe
                raise
            except Exception as error:  # a fault of the stage, of a library or of this machine
                at.fail(recipe, home.relative(f"{type(error).__name__}: {error}"))
                raise
    except StoreError as error:
        raise NotMade(home.relative(str(error))) from error


def _produce(home, snapshot, node, key, sink, parts, recipe) -> Made:
    at = place(home, node, key)
    inputs = _inputs(home, snapshot, node, key)
    started = time.perf_counter()
    whole_s = None
    work = _work(snapshot, node, key, parts)
    twin = _twin(home, snapshot, node, key, work)
    try:
        update = _to_update(at, parts) if twin is None and node.stage.updates else None
        part = at.begin(recipe, resume=node.stage.resumes and twin is None, update=update)
        if twin is not None:
            facts, whole_s = _copy(home, twin, key, part)
        else:
            # Stages multiply small matrices: more threads wait for each other, and a calibration takes ten times as long.
            with at.timed() as spent_s, progress.listening(sink), threadpool_limits(1):
                facts = stage_function(node.stage.run)(inputs, part, config_of(node))
            whole_s = _whole_s(update, part, spent_s()) if update else spent_s()
        check = check_function(node)
        findings = check(part) if check else []
        if not any(part.iterdir()):
            raise NotMade("the stage wrote nothing")
    except (BadInput, StoreError) as error:
        raise NotMade(home.relative(str(error))) from error
    except OSError as error:
        raise _not_written(home, error, at.part) from error
    record = {
        "schema": "sim1.artifact/1",
        "stage": node.stage.name,
        "variant": node.variant,
        "garment": key,
        "profile": snapshot.graph.profile,
        "recipe": recipe,
        "work": work,
        "parts": parts,
        "facts": json.loads(json.dumps(facts)),
        "findings": [
            {**vars(finding), "passed": bool(finding.passed)} for finding in findings
        ],  # numpy's bool is no JSON
        "seconds": round(time.perf_counter() - started, 3),
        "whole_s": whole_s,  # what making all of it took; None where nobody knows, as a process died over it
    }
    try:
        if failed := [finding for finding in findings if finding.blocking and not finding.passed]:
            at.reject(record)
            reasons = "; ".join(f"{finding.name}: {finding.detail}" for finding in failed)
            raise NotMade(
                home.relative(f"failed its checks: {reasons} (kept for a look in {at.rejected})"), findings=findings
            )
        return Made(at.final, at.commit(record), findings)
    except OSError as error:
        raise _not_written(home, error, at.part) from error


def _work(snapshot: Snapshot, node: Node, key: Key, parts: dict[str, Any]) -> str:
    """Digest of what the stage function is given, whichever node asks: content by input name, not by who made it."""
    given = {
        f"{name}/{parent_key or ''}": snapshot.version(parent, parent_key)
        for name, parent, parent_key in snapshot.parents(node, key)
    }
    return digest_json({**parts, "made_from": given})


def _twin(home: Home, snapshot: Snapshot, node: Node, key: Key, work: str) -> Node | None:
    """Another variant of the same stage that did this very work: a filter that changes nothing costs nothing below it."""
    if node.stage.timings or node.stage.compares:
        return None
    for other in snapshot.graph.nodes.values():
        if other.stage.name == node.stage.name and other.id != node.id:
            at = place(home, other, key)
            record = at.record()
            if record and record.get("work") == work and at.damage(record, thorough=True) is None:
                return other
    return None


def _to_update(at: Place, parts: dict[str, Any]) -> Path | None:
    """What was made last, if it is whole and the same version of the same function made it.

    That may be what failed its checks: most of it may be right, and the stage says itself what of it still holds. It is newer than
    the artifact, as an artifact that is put in place removes it.
    """
    if (record := at.whole_rejected()) and _of_the_same_function(record, parts):
        return at.rejected
    record = at.record()
    if record and _of_the_same_function(record, parts) and at.damage(record, thorough=True) is None:
        return at.final
    return None


def _of_the_same_function(record: dict[str, Any], parts: dict[str, Any]) -> bool:
    return all(record["parts"][key] == parts[key] for key in ("version", "function"))


def _copy(home: Home, twin: Node, key: Key, part: Path) -> tuple[dict[str, Any], float | None]:
    """Copy the twin's artifact into `part`; its facts, with a note of where they come from, and what making it took."""
    at = place(home, twin, key)
    shutil.copytree(at.final, part, dirs_exist_ok=True, ignore=shutil.ignore_patterns(RECORD))
    record = at.record()
    return {**record["facts"], "same_work_as": label(twin, key)}, record.get("whole_s")


def _whole_s(before: Path, part: Path, spent_s: float | None) -> float | None:
    """What making all of `part` took, which began with the artifact `before`: what was kept of that, at its share of its files, and what was spent now."""
    record = json.loads((before / RECORD).read_text())
    known_s, files = record.get("whole_s"), record["files"]
    if known_s is None or spent_s is None:
        return None
    kept = sum(_is_kept(part / name, known) for name, known in files.items())
    return round(known_s * kept / len(files) + spent_s, 3)


def _is_kept(file: Path, known: dict[str, Any]) -> bool:
    """Whether a file is that of the artifact before; one that still has its size and time, as most frames have, is not read for it."""
    if not file.is_file() or file.stat().st_size != known["size"]:
        return False
    return file.stat().st_mtime_ns == known["mtime_ns"] or digest_file(file) == known["sha256"]


def _inputs(home: Home, snapshot: Snapshot, node: Node, key: Key) -> dict[str, dict[str, Path]]:
    inputs: dict[str, dict[str, Path]] = {name: {} for name in node.needs}
    for name, parent, parent_key in snapshot.parents(node, key):
        folder, record = verified(home, parent, parent_key)
        if record["data_version"] != snapshot.version(parent, parent_key):
            raise StoreError(f"{folder}: is not the version that the event log knows; run it again: sim1 run")
        inputs[name][parent_key or ""] = folder
    for name in (*node.stage.sources, *node.stage.optional_sources):
        path = source(home, node, key, name)
        inputs[name] = {key or "": path} if path else {}
    if node.stage.timings:
        inputs["timings"] = {"": _timings(home, snapshot, place(home, node, key).part)}
    return inputs


def _timings(home: Home, snapshot: Snapshot, beside: Path) -> Path:
    """File {node: {garment: seconds}} of what making each whole artifact took, null where nobody knows; written outside the artifact to be made.

    A stage of which nothing has been made yet stands there too, with nothing, so that who reads the seconds can say what they leave out.
    """
    seconds: dict[str, dict[str, float | None]] = {id_: {} for id_ in snapshot.graph.nodes}
    for node, key in snapshot.artifacts():
        if record := place(home, node, key).record():
            seconds[node.id][key or ""] = record.get("whole_s")
    path = beside.with_name("timings.json")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(seconds, indent=1, sort_keys=True) + "\n")
    return path


def _not_written(home: Home, error: OSError, part: Path) -> NotMade:
    said = f"{error.strerror or error}: {error.filename or part}"
    if error.errno == errno.ENOSPC:
        free = os.statvfs(part.parent)
        said = (
            f"the disk is full: {error.filename or part} ({free.f_bavail * free.f_frsize / 2**20:.0f} MiB free); "
            "free some space and run again, nothing that was made before is lost"
        )
    return NotMade(home.relative(said), transient=error.errno != errno.ENOSPC)
