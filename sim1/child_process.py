"""What every process that this program starts needs."""

import multiprocessing
import os
import signal
import threading


def behave_as_child() -> None:
    """Called first in a child: its parent decides about Ctrl-C, and a killed parent leaves nobody behind."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    multiprocessing.parent_process().join()
    os._exit(1)
