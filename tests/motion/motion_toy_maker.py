"""Attempts that cost nothing: their outcome depends on the ticket alone."""

import os
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from sim1.crew import finished, labour
from sim1.quota import Quota, Row, Ticket
from sim1.stage import BadInput, random_stream


class ToyMaker:
    """Half of the attempts run, half of those succeed. Notes in a log who began what."""

    def __init__(self, log: Path, seconds: float = 0.0, fatal: int = -1, fault: str = ""):
        if fault:
            raise BadInput(fault)
        self.log, self.seconds, self.fatal = log, seconds, fatal

    def make(self, ticket: Ticket, folder: Path) -> Row:
        with self.log.open("a") as file:
            file.write(f"{os.getpid()} {ticket.name}\n")
        if ticket.number == self.fatal:
            os._exit(7)
        stream = random_stream(0, "toy", ticket.series, ticket.number)
        ran, success = bool(stream.random() < 0.5), bool(stream.random() < 0.5)
        time.sleep(self.seconds)
        if ran:
            np.save(folder / "episode.npy", stream.random(100))
            time.sleep(self.seconds)
            (folder / "episode.json").write_text("{}")
        return {"ran": ran, "success": ran and success, "episode": ticket.name}


def command(root: Path, quotas: Sequence[Quota], log: Path, seconds: float) -> None:
    """What a whole command does in a folder."""
    labour(root, quotas, ToyMaker(log, seconds))
    finished(root)
