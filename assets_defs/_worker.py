"""A process that materializes assets one after the other on request; its end, however it comes, is an answer too."""

import contextlib
import logging
import multiprocessing
import os
import signal
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

import dagster as dg

from assets_defs._recipe import Key
from pipeline import Graph, Home, load_graph
from sim1.child_process import behave_as_child

PID_TAG = "sim1/pid"


@dataclass(frozen=True)
class Progress:
    """How far a worker's task is."""

    done: float
    total: float
    what: str


@dataclass(frozen=True)
class Outcome:
    """How a worker's task ended."""

    ok: bool
    message: str  # why not; whose it is, is known


class Worker:
    """Parent's side of a worker process."""

    def __init__(self, root: Path, profile: str):
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, str(root), profile), daemon=False)
        with _environment(SIM1_HOME=str(root), SIM1_PROFILE=profile, DAGSTER_HOME=str(root)):
            self._process.start()
        theirs.close()
        self.task: tuple[str, Key] | None = None

    def begin(self, id_: str, key: Key) -> None:
        self.task = (id_, key)
        self.pipe.send(self.task)

    def answer(self) -> Progress | Outcome:
        """Next message of the worker; a process that died is a failed task."""
        try:
            message = self.pipe.recv()
        except (EOFError, ConnectionError):
            self._process.join(timeout=5)
            return Outcome(False, _death(self._process.exitcode))
        return message

    @property
    def alive(self) -> bool:
        return self._process.is_alive()

    def stop(self) -> None:
        """End the process; a task under way is lost, its artifact untouched."""
        with contextlib.suppress(OSError):
            self.pipe.close()
        if self.task is None:
            self._process.join(timeout=2)
        if self._process.is_alive():
            self._process.terminate()
            self._process.join(timeout=5)
        if self._process.is_alive():
            self._process.kill()


class Inline:
    """The same for this very process: no start-up time, no protection against crashes; for debuggers and tests."""

    pipe = None
    alive = True

    def __init__(self, home: Home, graph: Graph, instance: dg.DagsterInstance):
        from assets_defs.definitions import bind_all

        self._assets, self._instance = bind_all(graph, home), instance
        self.task: tuple[str, Key] | None = None
        self._outcome: Outcome | None = None

    def begin(self, id_: str, key: Key) -> None:
        self.task = (id_, key)
        self._outcome = _materialize(self._instance, self._assets[id_], key)

    def answer(self) -> Outcome:
        return self._outcome

    def stop(self) -> None:
        pass


def _death(exit_code: int | None) -> str:
    if exit_code == -signal.SIGKILL:
        return "the process was killed (out of memory?); close other programs or run with --jobs 1"
    if exit_code is not None and exit_code < 0:
        return (
            f"the process died of signal {signal.Signals(-exit_code).name}; its last words are in .dagster/worker.log"
        )
    return f"the process ended with code {exit_code}; its last words are in .dagster/worker.log"


@contextlib.contextmanager
def _environment(**values: str):
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _serve(pipe: Connection, root: str, profile: str) -> None:
    behave_as_child()
    os.environ.update(SIM1_HOME=root, SIM1_PROFILE=profile, DAGSTER_HOME=root, OMP_NUM_THREADS="1")
    os.chdir(root)
    logging.disable(logging.CRITICAL)
    # Native libraries talk on both streams; the terminal belongs to the parent.
    with (Home(Path(root)).state / "worker.log").open("a") as log:
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)
    from assets_defs._factory import send_progress_to
    from assets_defs.definitions import bind_all

    home = Home(Path(root))
    assets = bind_all(load_graph(home, profile), home)

    def tell(done: float, total: float, what: str) -> None:
        with contextlib.suppress(ConnectionError):  # nobody listens any more: no fault of the stage that reports
            pipe.send(Progress(done, total, what))

    send_progress_to(tell)
    with dg.DagsterInstance.get() as instance:
        while True:
            try:
                id_, key = pipe.recv()
            except EOFError:
                return
            pipe.send(_materialize(instance, assets[id_], key))


def _materialize(instance: dg.DagsterInstance, asset: dg.AssetsDefinition, key: Key) -> Outcome:
    result = dg.materialize(
        [asset],
        partition_key=key,
        instance=instance,
        raise_on_error=False,
        tags={PID_TAG: str(os.getpid())},
    )
    if result.success:
        return Outcome(True, "")
    for event in reversed(result.all_events):
        if event.is_step_failure:
            failure = event.step_failure_data
            said = failure.user_failure_data
            if said and said.description:
                return Outcome(False, said.description)
            error = failure.error.cause or failure.error
            return Outcome(False, error.message.strip())
    return Outcome(False, "the run failed; see it in the UI")
