"""`sim1 diagnose` as a program that somebody ends: what it knows by then is written, and none of its processes is left."""

import os
import signal
import subprocess
import sys
import time

from small_bundle import empty_bundle, filmed

from pipeline.home import REPOSITORY
from sim1.cloth.physics import read_physics
from sim1.mismatch.verdict import read_verdict
from sim1.recording.bundle import write_bundle

BEGIN = (
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # what runs behind a shell's back ignores it
    "import runpy; runpy.run_module('assets_defs._diagnose', run_name='__main__')"
)


def test_after_a_ctrl_c_what_is_known_is_written_and_no_process_is_left(tmp_path):
    write_bundle(tmp_path / "bundle", filmed(empty_bundle(count=5, motions=2, duration_s=1.0), air_normal=3.0))
    out = tmp_path / "out"
    program = subprocess.Popen(
        [sys.executable, "-c", BEGIN, "diagnose", str(tmp_path / "bundle"), "--out", str(out)],
        cwd=REPOSITORY,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    until = time.monotonic() + 120
    while not (out / "baseline.yaml").exists() and program.poll() is None and time.monotonic() < until:
        time.sleep(0.05)
    assert read_physics(out / "baseline.yaml").effects == ()  # as soon as it is calibrated
    assert not (out / "verdict.json").exists()
    os.killpg(program.pid, signal.SIGINT)  # as a terminal does: its workers get it too
    said, _ = program.communicate(timeout=120)  # the last that could still say something has ended
    assert program.returncode == 0, said
    assert "more time" in read_verdict(out / "verdict.json").next_experiment
    assert (out / "report.html").is_file()
