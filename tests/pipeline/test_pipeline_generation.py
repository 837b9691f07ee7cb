"""`sim1 generate` undisturbed, and killed ten times at random: the same episodes to the byte."""

import os
import signal
from pathlib import Path
from subprocess import TimeoutExpired

import pandas as pd
import pytest

from sim1.stage import random_stream

TARGET = "4"
KILLS = 10


def content(root: Path) -> dict[str, bytes]:
    return {str(path.relative_to(root)): path.read_bytes() for path in sorted(root.rglob("*")) if path.is_file()}


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_a_run_that_is_killed_ten_times_ends_with_the_episodes_of_an_undisturbed_one(home, sim1, tmp_path):
    """Real attempts of the towel in its smallest size, undisturbed by one process, killed by two."""
    made = sim1("run", "--profile", "smoke", "--variant", "base", "--select", "valid_trajectories")
    assert made.returncode == 0, made.stdout[-4000:] + made.stderr[-4000:]
    whole = sim1("generate", "towel", "--target", TARGET, "--workers", "1", "--out", str(tmp_path / "whole"))
    assert whole.returncode == 0, whole.stderr
    killed = tmp_path / "killed"
    command = ("generate", "towel", "--target", TARGET, "--workers", "2", "--out", str(killed))
    stream = random_stream(0, "kills")
    known = []
    for _ in range(KILLS):
        process = sim1.start(*command)
        try:
            process.wait(timeout=float(stream.uniform(4, 14)))
        except TimeoutExpired:
            os.kill(process.pid, signal.SIGKILL)
        process.communicate()
        known.append(len(list((killed / "attempts").glob("*.json"))))
    answer = sim1(*command)
    assert answer.returncode == 0, answer.stderr
    assert known == sorted(known)
    assert content(killed) == content(tmp_path / "whole")
    table = pd.read_parquet(killed / "attempts.parquet")
    assert table.accepted.sum() == int(TARGET)
    assert not table.failure[~table.accepted].isna().any()
