"""`sim1 generate` undisturbed, and killed again and again amid its attempts: the same episodes to the byte; a dataset of them."""

import os
import signal
import time
from contextlib import suppress
from pathlib import Path
from subprocess import Popen

import pandas as pd
import pytest

from sim1.stage import random_stream

TARGET = "8"
KILLS = 20
LANDED = 10  # kills amid an attempt, of those
LONGEST_S = 1.5  # from where an attempt is seen to the kill: an attempt takes seconds


def content(root: Path) -> dict[str, bytes]:
    return {str(path.relative_to(root)): path.read_bytes() for path in sorted(root.rglob("*")) if path.is_file()}


def under_way(root: Path) -> set[tuple[str, str]]:
    """Attempts that were begun and are not made, each with the process that began it last, from the folder's own locks."""
    made = {path.stem for path in (root / "attempts").glob("*.json")}
    begun = set()
    for path in (root / "work").glob("*.lock"):
        with suppress(FileNotFoundError):  # a run that has enough takes its locks away
            begun.add((path.stem, path.read_text()))
    return {(name, process) for name, process in begun if process and name not in made}


def killed_at_work(process: Popen, root: Path, delay_s: float) -> bool:
    """Kill a run `delay_s` after it is seen at an attempt; whether one that it had begun was left unmade."""
    before = under_way(root)  # of those who were killed earlier
    while process.poll() is None and not under_way(root) - before:
        time.sleep(0.02)
    time.sleep(delay_s)
    if process.poll() is None:
        os.kill(process.pid, signal.SIGKILL)
    process.communicate()  # its workers hold the pipes, and end with it
    return process.returncode == -signal.SIGKILL and bool(under_way(root) - before)


@pytest.fixture(scope="module")
def whole(sim1, tmp_path_factory) -> Path:
    """Real attempts of the towel in its smallest size, by one process that nobody disturbs."""
    stages = [word for stage in ("valid_trajectories", "mismatch_report") for word in ("--select", stage)]
    made = sim1("run", "--profile", "smoke", "--variant", "base", *stages)
    assert made.returncode == 0, made.stdout[-4000:] + made.stderr[-4000:]
    folder = tmp_path_factory.mktemp("generated") / "whole"
    answer = sim1("generate", "towel", "--target", TARGET, "--workers", "1", "--out", str(folder))
    assert answer.returncode == 0, answer.stderr
    return folder


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_a_run_that_is_killed_amid_its_attempts_ends_with_the_episodes_of_an_undisturbed_one(whole, sim1, tmp_path):
    """Two processes make them, and are killed."""
    killed = tmp_path / "killed"
    command = ("generate", "towel", "--target", TARGET, "--workers", "2", "--out", str(killed))
    stream = random_stream(0, "kills")
    known, landed = [], []
    for _ in range(KILLS):
        process = sim1.start(*command)
        landed.append(killed_at_work(process, killed, float(stream.uniform(0, LONGEST_S))))
        known.append(len(list((killed / "attempts").glob("*.json"))))
        if process.returncode == 0:  # there is enough
            break
    assert sum(landed) >= LANDED, f"kills that left an attempt unmade: {landed}, attempts made by then: {known}"
    answer = sim1(*command)
    assert answer.returncode == 0, answer.stderr
    assert known == sorted(known)
    assert content(killed) == content(whole)
    table = pd.read_parquet(killed / "attempts.parquet")
    assert table.accepted.sum() == int(TARGET)
    assert not table.failure[~table.accepted].isna().any()


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_generated_episodes_become_a_dataset_that_passes_its_checks(whole, sim1, tmp_path):
    answer = sim1("dataset", "make", str(whole), "--out", str(tmp_path / "made"))
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout.startswith(f"{TARGET} episodes")
    checked = sim1("dataset", "check", str(tmp_path / "made" / "dataset"))
    assert checked.returncode == 0, checked.stdout
    assert "joints_within_limits" in checked.stdout
    table = pd.read_parquet(tmp_path / "made" / "dataset" / "provenance.parquet")
    assert table.trajectory.str.startswith("seed1_").all()
    assert table.task.unique().tolist() == ["fold the towel"]
    assert table.physics.notna().all()
