"""Writing sessions in a thread of its own, so that the next one can be simulated meanwhile."""

import queue
import threading
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from sim1.episode import Episode, write_episode
from sim1.robot.session_usd import write_session_usd
from sim1.scene.description import Scene


class SessionWriter:
    """A context: `put` hands an episode over and waits while `limit` of them are in line; errors come out of `put` or the end."""

    def __init__(self, folder: Path, faces: np.ndarray, scene: Scene, *, limit: int) -> None:
        self._folder, self._faces, self._scene = folder, faces, scene
        self._line: queue.Queue[tuple[str, Episode] | None] = queue.Queue(maxsize=limit)
        self._problem: BaseException | None = None
        self._thread = threading.Thread(target=self._work, name="session writer", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def put(self, name: str, episode: Episode) -> None:
        """Write `episode` under `name`, soon.

        Raises:
            OSError: (or whatever stopped the writer) an earlier episode could not be written.
        """
        if self._problem is not None:
            raise self._problem
        self._line.put((name, episode))

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._line.put(None)
        self._thread.join()
        if self._problem is not None and error is None:
            raise self._problem

    def _work(self) -> None:
        while (job := self._line.get()) is not None:
            if self._problem is not None:
                continue  # keep emptying the line, so that nobody waits for a writer that stopped
            try:
                name, episode = job
                write_episode(self._folder / name, episode)
                write_session_usd(self._folder / name / "session.usdc", episode, self._faces, self._scene)
            except BaseException as problem:
                self._problem = problem
