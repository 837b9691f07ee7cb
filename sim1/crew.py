"""Attempts made by any number of processes in one folder, which they share through lock files alone.

    episodes/NNNN/      an attempt that ran, whole or absent
    attempts/NNNN.json  the row of an attempt that is made; written last
    work/NNNN.lock      held by the process that makes it; a killed process lets go by itself
    work/crew           held by all who work here; who gets it alone, the last one, removes `work/`

Every process asks the folder what is made, takes the lowest attempt that is wanted and that nobody holds, makes it, and asks
again. Processes may come and go, on one machine or on several that share the folder and its locks.
"""

import json
import multiprocessing
import shutil
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Protocol

from sim1.child_process import behave_as_child
from sim1.lock import Taken, exclusive, shared
from sim1.quota import Quota, Row, Ticket, open_tickets
from sim1.stage import BadInput

CREW = "crew"
WAIT_S = 0.2  # between two looks at what others have made


class CrewDied(RuntimeError):
    """Processes ended before enough was made."""


class Maker(Protocol):
    """Makes attempts. The same ticket gives the same row and files, whoever makes it."""

    def make(self, ticket: Ticket, folder: Path) -> Row:
        """The attempt's row (JSON), and its files in `folder` where it ran."""
        ...


type Tell = Callable[[dict[str, Row]], None]
type Foreseen = tuple[type[Exception], ...]


@dataclass(frozen=True, kw_only=True)
class Shop:
    """The folder."""

    root: Path
    _rows: dict[str, Row] = field(default_factory=dict)  # rows never change once they are written

    @property
    def work(self) -> Path:
        return self.root / "work"

    def at_work(self) -> AbstractContextManager[None]:
        """As long as it is held, nobody removes `work/`."""
        return shared(self.work / CREW)

    def tidied(self) -> None:
        """Remove `work/`, unless somebody is at work."""
        if not self.work.exists():
            return
        with suppress(Taken), exclusive(self.work / CREW):
            for path in self.work.iterdir():
                if path.is_dir():
                    shutil.rmtree(path)
                elif path.name != CREW:
                    path.unlink()
            (self.work / CREW).unlink()  # last: until then, who comes waits for it
            with suppress(OSError):  # somebody came since
                self.work.rmdir()

    def rows(self) -> dict[str, Row]:
        """Rows of all attempts that are made, by name.

        Raises:
            BadInput: a row is damaged.
        """
        for path in (self.root / "attempts").glob("*.json"):
            if path.stem not in self._rows:
                try:
                    self._rows[path.stem] = json.loads(path.read_text())
                except ValueError as error:
                    raise BadInput(
                        f"{path}: not a readable attempt ({error}); delete the file, it is made again"
                    ) from None
        return self._rows

    def make(self, ticket: Ticket, maker: Maker) -> None:
        """Make one attempt and put it in place.

        Raises:
            Taken: another process makes it.
        """
        with exclusive(self.work / f"{ticket.name}.lock"):
            if ticket.name in self.rows():  # made and let go of since we looked
                return
            part = self.work / ticket.name
            shutil.rmtree(part, ignore_errors=True)
            part.mkdir()
            row = maker.make(ticket, part)
            note = self.work / f"{ticket.name}.json"
            note.write_text(json.dumps(row, indent=1, sort_keys=True, allow_nan=False) + "\n")
            episode = self.root / "episodes" / ticket.name
            shutil.rmtree(episode, ignore_errors=True)  # of a process that was killed before it wrote the row
            if any(part.iterdir()):
                episode.parent.mkdir(exist_ok=True)
                part.rename(episode)
            (self.root / "attempts").mkdir(exist_ok=True)
            note.rename(self.root / "attempts" / note.name)


def labour(root: Path, quotas: Sequence[Quota], maker: Maker, tell: Tell = lambda rows: None) -> None:
    """Make attempts until the quotas have enough, beside whoever else does."""
    shop = Shop(root=root)
    with shop.at_work():
        while True:
            tell(shop.rows())
            for ticket in open_tickets(quotas, shop.rows()):
                try:
                    shop.make(ticket, maker)
                    break
                except Taken:
                    continue
            else:
                if not open_tickets(quotas, shop.rows()):
                    return
                time.sleep(WAIT_S)


def _child(
    root: Path, quotas: Sequence[Quota], prepare: Callable[[], Maker], said: Connection, foreseen: Foreseen
) -> None:
    behave_as_child()
    try:
        labour(root, quotas, prepare())
    except foreseen as error:
        said.send(error)


def labour_together(
    root: Path,
    quotas: Sequence[Quota],
    prepare: Callable[[], Maker],
    workers: int,
    tell: Tell,
    foreseen: Foreseen = (BadInput,),
) -> None:
    """The same with `workers` processes, each with a maker of its own. `prepare` can be pickled.

    Raises:
        BadInput: an input is at fault; or what else is `foreseen`, errors of a maker that tell a person enough.
        CrewDied: processes died before enough was made; what is made stays.
    """
    if workers == 1:
        labour(root, quotas, prepare(), tell)
        return
    context = multiprocessing.get_context("spawn")
    heard, said = context.Pipe(duplex=False)
    crew = [context.Process(target=_child, args=(root, quotas, prepare, said, foreseen)) for _ in range(workers)]
    shop = Shop(root=root)
    try:
        for process in crew:
            process.start()
        while any(process.is_alive() for process in crew):
            tell(shop.rows())
            wait([heard, *(process.sentinel for process in crew if process.is_alive())], WAIT_S)
            if heard.poll():
                raise heard.recv()
    finally:
        for process in crew:
            if process.is_alive():
                process.kill()
                process.join()
    tell(shop.rows())
    if left := open_tickets(quotas, shop.rows()):
        died = [f"{process.pid} ({process.exitcode})" for process in crew if process.exitcode]
        raise CrewDied(
            f"{root}: processes died (number and exit code): {', '.join(died)}; attempt {left[0].name} is not made; "
            "what is made stays, the same command goes on from there"
        )


def finished(root: Path, conclude: Callable[[list[Row]], None] = lambda rows: None) -> list[Row]:
    """Rows of all attempts in the folder, series by series, in order; what only the work needed is removed with the last who works.

    They may be more than the quotas ask for, where those were larger once: what is made is kept. `conclude` is given them, one
    process at a time, so that what it writes is of all that is made by then.
    """
    shop = Shop(root=root)
    with shop.at_work(), exclusive(shop.work / "conclusion", patient=True):
        rows = shop.rows()
        ordered = [rows[name] for name in sorted(rows, key=lambda name: (len(name), name))]
        conclude(ordered)
    shop.tidied()
    return ordered
