"""The parent's side of one of Blender's processes: its orders go in, its lines come out, and its last words are kept."""

import contextlib
import os
import subprocess
import tempfile
import threading
from collections.abc import Sequence
from pathlib import Path
from queue import SimpleQueue

import sim1
from sim1.render.shares import Order

type Said = tuple[BlenderProcess, str | None]
"""Who said a line; None: it has ended."""


class BlenderProcess:
    """A process that renders what it is ordered to, one order after the other.

    Args:
        command: of the process.
        said: where its lines go, beside those of others.

    Attributes:
        device: what it renders on; None until it is ready.
        clip: key of the clip that it has set up.
        owed: pictures of its order that it has not rendered yet.
        dismissed: whether it was told that nothing is left.
    """

    def __init__(self, command: Sequence[str], said: SimpleQueue[Said]):
        self.device: str | None = None
        self.clip: str | None = None
        self.owed = 0
        self.dismissed = False
        path = [str(Path(sim1.__file__).parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])]
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115  until `close`
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
            errors="replace",
            env={**os.environ, "PYTHONPATH": os.pathsep.join(path)},
        )
        self._listener = threading.Thread(target=self._listen, args=(said,), daemon=True)
        self._listener.start()

    def _listen(self, said: SimpleQueue[Said]) -> None:
        for line in self._process.stdout:
            said.put((self, line))
        said.put((self, None))

    def send(self, order: Order) -> None:
        """Let it render."""
        self.clip, self.owed = order.clip, len(order.pictures)
        with contextlib.suppress(BrokenPipeError):  # it is dead, which its end tells
            self._process.stdin.write(order.line())
            self._process.stdin.flush()

    def dismiss(self) -> None:
        """Let it end: nothing is left to render."""
        self.dismissed = True
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()

    def kill(self) -> None:
        """End it at once, if it has not ended."""
        self._process.kill()

    def ended(self) -> tuple[int, str]:
        """Its exit code, negative after a signal, and what it said on the standard error; waits for its end."""
        code = self._process.wait()
        self._listener.join()
        self._errors.seek(0)
        return code, self._errors.read().decode(errors="replace")

    def close(self) -> None:
        """Let go of its files, after its end."""
        self.ended()
        self.dismiss()
        self._process.stdout.close()
        self._errors.close()
