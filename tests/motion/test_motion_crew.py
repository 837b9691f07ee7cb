"""Attempts made by one process, by many, and by many that are killed: always the same."""

import functools
import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from motion_toy_maker import ToyMaker, command

from sim1.crew import CrewDied, Shop, finished, labour, labour_together
from sim1.lock import Taken, exclusive
from sim1.quota import Quota, Row, Ticket, open_tickets
from sim1.stage import BadInput

MEANT = Quota(series="", run_count=4, target=5, counted="success", run_limit=30, try_limit=100)
PERTURBED = Quota(series="perturbed", run_count=2, target=0, counted="success", run_limit=2, try_limit=8)
QUOTAS = (MEANT, PERTURBED)


def content(root: Path) -> dict[str, bytes]:
    return {str(path.relative_to(root)): path.read_bytes() for path in sorted(root.rglob("*")) if path.is_file()}


@pytest.fixture
def alone(tmp_path) -> dict[str, bytes]:
    root = tmp_path / "alone"
    labour(root, QUOTAS, ToyMaker(tmp_path / "log"))
    finished(root)
    return content(root)


def test_a_series_ends_when_enough_ran_and_enough_succeeded(tmp_path):
    labour(tmp_path, QUOTAS, ToyMaker(tmp_path / "log"))
    rows = finished(tmp_path)
    meant = [row for row in rows if not row["episode"].startswith("perturbed")]
    assert sum(row["success"] for row in meant) == 5
    assert meant[-1]["success"]
    assert sum(row["ran"] for row in rows if row["episode"].startswith("perturbed")) == 2
    assert {path.name for path in (tmp_path / "episodes").iterdir()} == {row["episode"] for row in rows if row["ran"]}


def begun(log: Path) -> list[tuple[str, ...]]:
    """Process and name of every attempt that was begun."""
    return [tuple(line.split()) for line in log.read_text().splitlines()] if log.exists() else []


def comes_true(happens: Callable[[], bool]) -> bool:
    """Whether it happens within a minute."""
    deadline = time.monotonic() + 60
    while not (come := happens()) and time.monotonic() < deadline:
        time.sleep(0.01)
    return come


class MeetingMaker(ToyMaker):
    """Ends its first attempt only once three processes have begun one: else one might make all by itself."""

    waited = False

    def make(self, ticket: Ticket, folder: Path) -> Row:
        row = super().make(ticket, folder)
        if not self.waited:
            self.waited = True
            comes_true(lambda: len({process for process, _ in begun(self.log)}) >= 3)
        return row


def test_three_processes_make_what_one_makes_and_nothing_twice(tmp_path, alone):
    root, log = tmp_path / "crew", tmp_path / "crew.log"
    labour_together(root, QUOTAS, functools.partial(MeetingMaker, log), 3, lambda rows: None)
    finished(root)
    assert content(root) == alone
    names = [name for _, name in begun(log)]
    assert len(names) == len(set(names))
    assert len({process for process, _ in begun(log)}) == 3


class StuckMaker(ToyMaker):
    """Is stuck amid the attempt with which the log has `lines`, and amid those after it, until somebody kills it."""

    def __init__(self, log: Path, lines: int):
        super().__init__(log)
        self.lines = lines

    def make(self, ticket: Ticket, folder: Path) -> Row:
        row = super().make(ticket, folder)
        if len(begun(self.log)) >= self.lines:
            (folder / "half").write_text("of what nobody ends")
            time.sleep(120)
        return row


def test_a_run_that_is_killed_again_and_again_amid_its_attempts_ends_with_the_same_files(tmp_path, alone):
    root, log = tmp_path / "killed", tmp_path / "killed.log"
    context = multiprocessing.get_context("spawn")
    for _ in range(3):
        lines = len(begun(log)) + 3
        prepare = functools.partial(StuckMaker, log, lines)
        process = context.Process(target=labour_together, args=(root, QUOTAS, prepare, 2, print))
        process.start()
        assert comes_true(lambda lines=lines: len(begun(log)) >= lines)
        os.kill(process.pid, signal.SIGKILL)
        process.join()
        assert process.exitcode == -signal.SIGKILL
        made = {path.stem for path in (root / "attempts").glob("*.json")}
        assert {name for _, name in begun(log)} - made
    labour(root, QUOTAS, ToyMaker(log))
    finished(root)
    assert content(root) == alone


def test_a_larger_target_goes_on_and_a_smaller_one_loses_nothing(tmp_path, alone):
    root = tmp_path / "grown"
    more = (Quota(**{**MEANT.__dict__, "target": 8}), PERTURBED)
    for quotas in (QUOTAS, more):
        labour(root, quotas, ToyMaker(tmp_path / "grown.log"))
    rows = finished(root)
    assert sum(row["success"] for row in rows if not row["episode"].startswith("perturbed")) == 8
    grown = content(root)
    assert {name: grown[name] for name in alone} == alone
    labour(root, QUOTAS, ToyMaker(tmp_path / "grown.log"))
    assert finished(root) == rows
    assert content(root) == grown


def test_commands_with_different_targets_share_a_folder_and_none_destroys_the_work_of_another(tmp_path):
    root, log, alone = tmp_path / "shared", tmp_path / "log", tmp_path / "alone"
    small, large = ((Quota(**{**MEANT.__dict__, "run_count": 1, "target": target}),) for target in (1, 8))
    context = multiprocessing.get_context("spawn")
    crew = [context.Process(target=command, args=(root, quotas, log, 0.15)) for quotas in (small, large, small, large)]
    for process in crew:
        process.start()
    for process in crew:
        process.join()
    assert [process.exitcode for process in crew] == [0] * 4
    command(alone, large, tmp_path / "alone.log", 0.0)
    assert content(root) == content(alone)
    assert sorted(line.split()[1] for line in log.read_text().splitlines()) == sorted(
        path.stem for path in (root / "attempts").iterdir()
    )


def test_only_the_last_who_works_in_a_folder_tidies_it_up(tmp_path):
    shop = Shop(root=tmp_path)
    with shop.at_work():
        (shop.work / "0003").mkdir()  # half made
        finished(tmp_path)
        assert (shop.work / "0003").exists()
    finished(tmp_path)
    assert not shop.work.exists()


def test_processes_conclude_one_after_the_other(tmp_path):
    """So who concludes last does it of all that is made."""
    heard = []

    def conclude(rows):
        with pytest.raises(Taken), exclusive(tmp_path / "work" / "conclusion"):
            pass
        heard.append(len(rows))

    labour(tmp_path, QUOTAS, ToyMaker(tmp_path / "log"))
    assert len(finished(tmp_path, conclude)) == heard[0] > 0


def test_rows_come_in_the_order_of_their_numbers_also_beyond_four_digits(tmp_path):
    (tmp_path / "attempts").mkdir()
    names = ["0002", "9999", "10000", "perturbed_0001"]
    for name in reversed(names):
        (tmp_path / "attempts" / f"{name}.json").write_text(f'{{"episode": "{name}"}}')
    assert [row["episode"] for row in finished(tmp_path)] == names


def test_a_process_that_dies_is_named_with_the_attempt_it_leaves(tmp_path):
    prepare = functools.partial(ToyMaker, tmp_path / "log", 0.0, 3)
    with pytest.raises(CrewDied, match=r"\(7\).*0003 is not made"):
        labour_together(tmp_path / "crew", QUOTAS, prepare, 2, lambda rows: None)


def test_a_fault_that_a_process_finds_in_the_input_ends_all_of_them(tmp_path):
    prepare = functools.partial(ToyMaker, tmp_path / "log", 0.0, -1, "mesh.npz: 3 vertices")
    with pytest.raises(BadInput, match=r"mesh\.npz: 3 vertices"):
        labour_together(tmp_path / "crew", QUOTAS, prepare, 2, lambda rows: None)


def test_another_error_that_tells_enough_comes_as_it_is(tmp_path):
    prepare = functools.partial(ToyMaker, tmp_path / "log", seconds="long")  # an error of Python's own
    with pytest.raises(TypeError, match="'str' object"):
        labour_together(tmp_path / "crew", QUOTAS, prepare, 2, lambda rows: None, (BadInput, TypeError))


def test_a_damaged_row_is_named(tmp_path):
    labour(tmp_path, QUOTAS, ToyMaker(tmp_path / "log"))
    (tmp_path / "attempts" / "0001.json").write_text('{"ran": tr')
    with pytest.raises(BadInput, match=r"0001\.json.*delete"):
        finished(tmp_path)


def test_what_a_killed_process_left_half_done_is_made_again(tmp_path, alone):
    root = tmp_path / "half"
    name = next(path for path in alone if path.startswith("episodes/")).split("/")[1]
    (root / "episodes" / name).mkdir(parents=True)
    (root / "episodes" / name / "episode.npy").write_bytes(b"half")
    (root / "work" / name).mkdir(parents=True)
    (root / "work" / name / "left").write_bytes(b"over")
    labour(root, QUOTAS, ToyMaker(tmp_path / "log2"))
    finished(root)
    assert content(root) == alone


outcomes = st.lists(st.sampled_from([(False, False), (True, False), (True, True)]), min_size=40, max_size=40)


@given(outcomes=outcomes, order=st.permutations(range(40)), target=st.integers(0, 6), runs=st.integers(1, 6))
def test_whatever_order_attempts_finish_in_none_is_made_in_vain(outcomes, order, target, runs):
    """Attempts that are asked for while others are under way are those that one after the other would make."""
    quota = Quota(series="", run_count=runs, target=target, counted="success", run_limit=10, try_limit=30)
    rows = [{"ran": ran, "success": success} for ran, success in outcomes]
    expected = 0
    while quota.wants_more(rows[:expected]):
        expected += 1
    done: dict[str, dict] = {}
    while tickets := open_tickets([quota], done):
        ticket = min(tickets, key=lambda ticket: order[ticket.number])
        done[ticket.name] = rows[ticket.number]
    assert sorted(done) == [f"{number:04d}" for number in range(expected)]


def test_a_held_attempt_is_left_to_its_holder(tmp_path):
    shop, ticket = Shop(root=tmp_path), Ticket(series="", number=0)
    with exclusive(tmp_path / "work" / "0000.lock"), pytest.raises(Taken):
        shop.make(ticket, ToyMaker(tmp_path / "log"))
    shop.make(ticket, ToyMaker(tmp_path / "log"))
    assert list(shop.rows()) == ["0000"]
