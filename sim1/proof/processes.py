"""Other programs, run to their end, several at once, each in a group of its own that can be ended as a whole.

A Ctrl-C of the terminal does not reach them: it would end a search early, and what a half search knows is no verdict to count.
"""

import contextlib
import os
import signal
import subprocess
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path

LAST_LINES = 5  # of what a program said, kept where it failed


class NotDone(RuntimeError):
    """A program failed; says how it ended and its last words."""


class Stopped(RuntimeError):
    """The campaign was stopped; nothing is known of the program."""


class Processes:
    """What runs at the moment."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._running: set[subprocess.Popen] = set()
        self._stopped = False

    def run(
        self,
        command: Sequence[str],
        *,
        cwd: Path,
        env: Mapping[str, str] | None = None,
        limit_s: float | None = None,
    ) -> str:
        """Run a program; returns what it said.

        Raises:
            NotDone: it cannot be started, failed, or ran longer than `limit_s`.
            Stopped: `stop` was called.
        """
        with self._lock:
            if self._stopped:
                raise Stopped
            try:
                process = subprocess.Popen(
                    command,
                    cwd=cwd,
                    env=None if env is None else dict(env),
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.STDOUT,
                    text=True,
                    errors="replace",
                    start_new_session=True,
                )
            except OSError as error:
                raise NotDone(f"{command[0]} cannot be started ({error})") from error
            self._running.add(process)
        try:
            said, _ = process.communicate(timeout=limit_s)
        except subprocess.TimeoutExpired:
            _end(process)
            process.communicate()
            raise NotDone(f"ran longer than {limit_s:.0f} s and was ended") from None
        except BaseException:  # Ctrl-C where nobody else is there to call `stop`
            _end(process)
            process.wait()
            process.stdout.close()
            raise
        finally:
            with self._lock:
                self._running.discard(process)
        if self._stopped:
            raise Stopped
        if process.returncode:
            last = " | ".join(line.strip() for line in said.splitlines()[-LAST_LINES:] if line.strip())
            raise NotDone(f"ended with {process.returncode}: {last}")
        return said

    def stop(self) -> None:
        """End all that runs and start nothing more."""
        with self._lock:
            self._stopped = True
            for process in self._running:
                _end(process)


def _end(process: subprocess.Popen) -> None:
    with contextlib.suppress(ProcessLookupError):  # it has just ended by itself
        os.killpg(process.pid, signal.SIGKILL)
