"""How long a search may go on: a budget of time, and a person who interrupts it. What is known by then is still reported."""

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

REPORT_S = 8.0  # for drawing and writing


class Patience:
    """Asked between simulations whether there is any left."""

    def __init__(self, budget_s: float | None = None):
        """`budget_s` for everything, the report included; None: as long as it takes."""
        self._ends = time.monotonic() + budget_s - REPORT_S if budget_s is not None else None
        self._interrupted = False
        self.reserve_s = 0.0  # what checking on held-out motion will take, as measured so far

    @property
    def over(self) -> bool:
        """Whether to come to an end."""
        return self._interrupted or (self._ends is not None and time.monotonic() + self.reserve_s > self._ends)

    def interrupt(self) -> None:
        """Come to an end now."""
        self._interrupted = True

    @contextmanager
    def interruptible(self) -> Iterator[None]:
        """Let Ctrl-C end the search instead of the program; a second one ends the program."""
        if threading.current_thread() is not threading.main_thread():
            yield  # only the main thread hears signals
            return
        before = signal.getsignal(signal.SIGINT)
        if before == signal.SIG_IGN:
            yield  # whoever started the program wants it undisturbed
            return

        def hear(number, frame):
            self.interrupt()
            signal.signal(signal.SIGINT, before)

        signal.signal(signal.SIGINT, hear)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)
