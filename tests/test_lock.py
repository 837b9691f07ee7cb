"""Locks of files: who holds one keeps the others out, also where the file is removed under their hands."""

import threading
import time
from pathlib import Path

import pytest

from sim1.lock import Taken, exclusive, shared


def test_a_held_lock_names_its_holder_and_is_free_afterwards(tmp_path):
    path = tmp_path / "locks" / "one.lock"
    with exclusive(path), pytest.raises(Taken, match=r"process \d+"), exclusive(path):
        pass
    with exclusive(path):
        pass


def test_many_share_a_lock_and_nobody_has_it_alone_until_the_last_has_gone(tmp_path):
    path = tmp_path / "one.lock"
    with shared(path):
        with shared(path):
            pass
        with pytest.raises(Taken), exclusive(path):
            pass
    with exclusive(path):
        pass


def test_a_lock_on_a_file_that_was_removed_meanwhile_is_taken_on_the_file_in_its_place(tmp_path):
    """Who waits gets the file that it opened, which is no longer the one that others see."""
    path, held, done = tmp_path / "one.lock", threading.Event(), threading.Event()

    def wait():
        with exclusive(path, patient=True):
            held.set()
            done.wait(30)

    with exclusive(path):
        waiting = threading.Thread(target=wait)
        waiting.start()
        deadline = time.monotonic() + 30
        while len(open_descriptors(path)) < 2:
            assert time.monotonic() < deadline, "nobody came to wait"
            time.sleep(0.01)
        path.unlink()
    assert held.wait(30)
    with pytest.raises(Taken), exclusive(path):
        pass
    done.set()
    waiting.join()


def open_descriptors(path):
    """Of this process, on the file."""
    links = []
    for descriptor in Path("/proc/self/fd").iterdir():
        try:
            links.append(descriptor.readlink())
        except FileNotFoundError:
            continue
    return [link for link in links if link == path]
