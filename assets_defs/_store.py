"""Artifacts on disk: written beside their place, checked, then renamed; verified before anyone reads them.

`data/store/STAGE/GARMENT/` (or `_` for a joint artifact; `data/store/variants/V/STAGE/...`) holds the artifact and its
record `artifact.json`. Beside it may stand `GARMENT.part` (being made), `GARMENT.old` (being replaced), `GARMENT.rejected`
(failed its checks) and `GARMENT.failed.json` (why the last try failed).
"""

import json
import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from assets_defs._digest import RECORD, content_files, digest_file, digest_files
from pipeline import Home, Node
from sim1.lock import Taken, exclusive

JOINT = "_"
REGENERATING = "regenerate.lock"  # in the state folder
PATIENCE = 200  # times 5 ms, that a reader waits for a writer between its two renames


class StoreError(RuntimeError):
    """An artifact can't be read or written; the message names the file and the remedy."""


@dataclass(frozen=True)
class Place:
    """Where the artifact of a node and a garment lies."""

    final: Path

    @property
    def part(self) -> Path:
        return self._beside("part")

    @property
    def old(self) -> Path:
        return self._beside("old")

    @property
    def rejected(self) -> Path:
        return self._beside("rejected")

    @property
    def failure(self) -> Path:
        return self._beside("failed.json")

    @property
    def lock(self) -> Path:
        return self._beside("lock")

    @property
    def _spent(self) -> Path:
        return self._beside("part.seconds")

    def _beside(self, suffix: str) -> Path:
        return self.final.with_name(f"{self.final.name}.{suffix}")

    def record(self) -> dict[str, Any] | None:
        """The artifact's record, or None where there is no whole artifact."""
        self._await()
        return _record_in(self.final)

    def whole_rejected(self) -> dict[str, Any] | None:
        """The record of what failed its checks, or None where there is none or somebody changed it."""
        record = _record_in(self.rejected)
        return record if record and _damage(self.rejected, record, thorough=True) is None else None

    def made_at(self) -> float:
        """When the artifact was put in place, seconds since the epoch."""
        return (self.final / RECORD).stat().st_mtime

    def damage(self, record: dict[str, Any], *, thorough: bool) -> str | None:
        """What is wrong with the artifact's files, or None. Not thorough: files with their size and time unchanged pass."""
        found = _damage(self.final, record, thorough=thorough)
        return " ".join(found) if found else None

    def begin(self, recipe: str, *, resume: bool, update: Path | None = None) -> Path:
        """A folder to make the artifact in.

        Args:
            recipe: of what is to be made.
            resume: go on in what an interrupted run of the same recipe left there.
            update: else begin with a copy of this folder, if one is given, instead of an empty one.
        """
        note = self._beside("part.recipe")
        if not (resume and self.part.is_dir() and note.is_file() and note.read_text() == recipe):
            note.unlink(missing_ok=True)  # of a copy that is cut short, nobody goes on
            shutil.rmtree(self.part, ignore_errors=True)
            if update:
                shutil.copytree(update, self.part, ignore=shutil.ignore_patterns(RECORD))
            else:
                self.part.mkdir(parents=True)
            self._spent.write_text("0")
            note.write_text(recipe)
        return self.part

    @contextmanager
    def timed(self) -> Iterator[Callable[[], float | None]]:
        """Add up what goes into `.part`, from one try to the next.

        Yields a function that says it afterwards, in seconds; None where a process died over it, as nobody knows then.
        """
        before = _number_in(self._spent)
        self._spent.unlink(missing_ok=True)  # who dies now leaves no figure
        started = time.perf_counter()
        total: list[float] = []
        try:
            yield lambda: total[0] if total else None
        finally:
            if before is not None:
                total.append(round(before + time.perf_counter() - started, 3))
                self._spent.write_text(str(total[0]))

    def commit(self, record: dict[str, Any]) -> dict[str, Any]:
        """Put the finished `.part` in place of the artifact and return its record, with data version and files."""
        whole = self._seal(record)
        shutil.rmtree(self.old, ignore_errors=True)
        if self.final.exists():
            self.final.rename(self.old)
        self.part.rename(self.final)
        shutil.rmtree(self.old, ignore_errors=True)
        self._beside("part.recipe").unlink(missing_ok=True)
        self._spent.unlink(missing_ok=True)
        self.failure.unlink(missing_ok=True)
        shutil.rmtree(self.rejected, ignore_errors=True)
        return whole

    def _seal(self, record: dict[str, Any]) -> dict[str, Any]:
        """Write the record of `.part`, with data version and files, into it."""
        files = {}
        for name, file in content_files(self.part):
            stat = file.stat()
            files[name] = {"size": stat.st_size, "mtime_ns": stat.st_mtime_ns, "sha256": digest_file(file)}
        version = digest_files({name: known["sha256"] for name, known in files.items()})
        whole = {**record, "data_version": version, "files": files}
        (self.part / RECORD).write_text(json.dumps(whole, indent=1, sort_keys=True) + "\n")
        return whole

    def reject(self, record: dict[str, Any]) -> None:
        """Keep an artifact that failed its checks, away from the good one: for a person to look at, and to go on from."""
        self._seal(record)
        shutil.rmtree(self.rejected, ignore_errors=True)
        self.part.rename(self.rejected)

    def fail(self, recipe: str, message: str) -> None:
        """Remember why this recipe failed, so that automation does not try it again and again."""
        self.final.parent.mkdir(parents=True, exist_ok=True)
        part = self.failure.with_suffix(".part")
        part.write_text(json.dumps({"recipe": recipe, "message": message}, indent=1) + "\n")
        part.rename(self.failure)

    def failed(self) -> dict[str, str] | None:
        try:
            return json.loads(self.failure.read_text())
        except (OSError, ValueError):
            return None

    def _recover(self) -> None:
        # Killed between the two renames of commit: the old artifact is whole, the new one may not be recorded anywhere.
        if self.old.exists() and not self.final.exists():
            self.old.rename(self.final)

    def _await(self) -> None:
        # A reader may come between the two renames of a writer that is alive: it waits, and repairs only if nobody writes.
        for _ in range(PATIENCE):
            if self.final.exists() or not self.old.exists():
                return
            try:
                with exclusive(self.lock):
                    self._recover()
                    return
            except Taken:
                time.sleep(0.005)

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold the artifact for writing; a killed process lets go by itself.

        Raises:
            StoreError: another process is making it.
        """
        with ExitStack() as stack:
            try:
                stack.enter_context(exclusive(self.lock))
            except Taken as error:
                raise StoreError(f"{self.final}: process {error.holder} is making it; wait for it or stop it") from None
            self._recover()
            yield


@contextmanager
def alone(home: Home) -> Iterator[None]:
    """Hold the whole store: nobody else regenerates or cleans meanwhile. Runs from the UI hold their artifacts alone.

    Raises:
        StoreError: somebody does already.
    """
    with ExitStack() as stack:
        try:
            stack.enter_context(exclusive(home.state / REGENERATING))
        except Taken as error:
            raise StoreError(
                f"process {error.holder} is regenerating already, or cleaning; wait for it or stop it"
            ) from None
        yield


def _record_in(folder: Path) -> dict[str, Any] | None:
    try:
        return json.loads((folder / RECORD).read_text())
    except (OSError, ValueError):
        return None


def _number_in(file: Path) -> float | None:
    try:
        return float(file.read_text())
    except (OSError, ValueError):
        return None


def _damage(folder: Path, record: dict[str, Any], *, thorough: bool) -> tuple[str, str] | None:
    """The first file at fault and what is wrong with it."""
    present = dict(content_files(folder))
    for name, known in record["files"].items():
        if (file := present.pop(name, None)) is None:
            return name, "is missing"
        stat = file.stat()
        if stat.st_size != known["size"]:
            return name, f"has {stat.st_size} bytes, was made with {known['size']}"
        unchanged = stat.st_mtime_ns == known["mtime_ns"]
        if (thorough or not unchanged) and digest_file(file) != known["sha256"]:
            return name, "has other content than was made"
    return (min(present), "does not belong to it") if present else None


def place(home: Home, node: Node, key: str | None) -> Place:
    """Place of the artifact of `node` for garment `key` (None: joint)."""
    root = home.store / "variants" / node.variant if node.variant else home.store
    return Place(root / node.stage.name / (key or JOINT))


def verified(home: Home, node: Node, key: str | None) -> tuple[Path, dict[str, Any]]:
    """Folder and record of an artifact whose every byte is as it was made.

    A damaged file that kept its size and time is touched: else a look that is not thorough would go on calling it
    whole, and nobody would make it again.

    Raises:
        StoreError: it is missing or damaged.
    """
    at = place(home, node, key)
    again = f"make it again: sim1 run --select {node.id}" + (f" --garment {key}" if key else "")
    if (record := at.record()) is None:
        raise StoreError(f"{at.final}: the artifact is missing; {again}")
    if damage := _damage(at.final, record, thorough=True):
        with suppress(OSError):  # it is missing
            os.utime(at.final / damage[0])
        raise StoreError(f"{at.final}: damaged: {' '.join(damage)}; {again}")
    return at.final, record
