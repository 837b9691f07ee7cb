"""A worker whose parent is gone: it ends, nothing is noted against its stage, and the next run makes the artifact."""

import os
import signal
import subprocess
import sys
import time

from assets_defs._regenerate import _alive
from assets_defs._store import place
from assets_defs._worker import Progress, Worker

PATIENCE_S = 120.0  # of a busy machine, to start two processes


def wait_until(is_so, what: str, seconds: float = PATIENCE_S) -> None:
    deadline = time.monotonic() + seconds
    while not is_so():
        assert time.monotonic() < deadline, what
        time.sleep(0.05)


def test_a_worker_ends_with_its_parent_and_the_next_run_makes_what_it_was_making(project):
    project.stages(model={"config": {"sleep_s": 120}})
    program = [sys.executable, "-c", "from assets_defs.cli import main; main()", "run", "--jobs", "1"]
    process = subprocess.Popen(program, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    at = place(project.home, project.graph.nodes["model"], "shirt")
    try:
        wait_until(at.part.exists, "the worker has begun nothing")
        worker = int(at.lock.read_text())
        assert worker != process.pid
    finally:
        process.kill()  # the parent alone
        process.wait()
    try:
        wait_until(lambda: not _alive(worker), "the worker goes on without its parent", 20.0)
    finally:
        if _alive(worker):
            os.kill(worker, signal.SIGKILL)
    assert at.failed() is None
    project.stages()
    assert list(project.run(nodes={"model"}, garments=["shirt"]).made) == ["model/shirt"]


def test_progress_that_nobody_hears_is_no_fault_of_the_stage(made):
    made.stages(model={"config": {"sleep_s": 1}})
    at = place(made.home, made.graph.nodes["model"], "towel")
    worker = Worker(made.root, "quick")
    try:
        worker.begin("model", "towel")
        assert isinstance(worker.answer(), Progress)
        worker.pipe.close()
        wait_until(lambda: not worker.alive, "the worker waits for more")
    finally:
        worker.stop()
    assert at.failed() is None
    assert at.record()["parts"]["config"] == {"sleep_s": 1}
