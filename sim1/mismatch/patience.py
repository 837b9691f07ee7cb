"""How long a search may go on: a budget of time, and whoever interrupts it. What is known by then is still reported."""

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

REPORT_S = 8.0  # for drawing and writing
HEARD = (signal.SIGINT, signal.SIGTERM)  # a person's Ctrl-C; `kill`, and a batch system before it kills for good


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
        """Let Ctrl-C or `kill` end the search instead of the program; a second one of either ends the program."""
        if threading.current_thread() is not threading.main_thread():
            yield  # only the main thread hears signals
            return
        before = {number: signal.getsignal(number) for number in HEARD}
        # What is ignored stays so: whoever started the program wants it undisturbed.
        heard = {number: handler for number, handler in before.items() if handler != signal.SIG_IGN}

        def as_before() -> None:
            for number, handler in heard.items():
                signal.signal(number, handler)

        def hear(number, frame) -> None:
            self.interrupt()
            as_before()

        for number in heard:
            signal.signal(number, hear)
        try:
            yield
        finally:
            as_before()
