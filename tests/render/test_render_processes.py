"""The processes in which Blender renders: what they say, how they end, and that none is left behind. Small programs stand for them."""

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from planned_towel import CONFIG, plan, with_frames
from towel_cell import write_inputs

from sim1.progress import listening
from sim1.render.appearance_file import read_about
from sim1.render.blender import BlenderFailed, run_blender, why_not_loaded
from sim1.render.stage import RenderConfig

ROOT = Path(__file__).parents[2]
# Keeps its orders in a file of its own. ACT stands for what it does before it says that a picture is rendered.
WORKER = """
import json, os, sys, time
from pathlib import Path

def first_of_all():
    try:
        return os.open(out / "first", os.O_CREAT | os.O_EXCL) >= 0
    except FileExistsError:
        return False

def wait_for(workers):
    while len(list(out.glob("*.orders"))) < workers:
        time.sleep(0.01)

out, threads = Path(sys.argv[2]), sys.argv[3]
say = lambda **message: print(json.dumps(message), flush=True)
say(device=DEVICE)
for line in sys.stdin:
    order = json.loads(line)
    with open(out / f"{os.getpid()}.orders", "a") as file:
        file.write(json.dumps({**order, "threads": threads}) + "\\n")
    for camera, frame in order["pictures"]:
        ACT
        say(rendered=frame)
"""


def stand_in(act: str = "pass", device: str = "cpu") -> tuple[str, ...]:
    return sys.executable, "-c", WORKER.replace("ACT", act).replace("DEVICE", repr(device))


@pytest.fixture
def planned(tmp_path):
    """Makes a job of two clips with 20 pictures each, for so many workers; its folder and that of the frames."""
    inputs = write_inputs(tmp_path, frame_count=39)

    def of(workers: int = 3):
        config = RenderConfig(**{**CONFIG.__dict__, "workers": workers})
        return plan(inputs, tmp_path / "out", config), tmp_path / "out"

    return of


def orders(out: Path) -> dict[int, list[dict]]:
    """What each process was ordered to do, by its number."""
    return {
        int(file.stem): [json.loads(line) for line in file.read_text().splitlines()] for file in out.glob("*.orders")
    }


def pictures(rows: list[dict]) -> list[tuple]:
    return [(row["clip"], camera, frame) for row in rows for camera, frame in row["pictures"]]


def is_alive(number: int) -> bool:
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    return True


def test_frames_that_are_there_are_kept_and_all_others_are_rendered_once_by_several_workers(planned):
    job, out = planned()
    there = with_frames(out, job)
    seen = []
    with listening(lambda *told: seen.append(told)):
        run_blender(job.folder, out, command=stand_in("wait_for(3)"))
    assert seen == [(done, 40, "frames") for done in range(len(there), 41)]
    found = orders(out)
    assert Counter(picture for rows in found.values() for picture in pictures(rows)) == Counter(
        (clip.key, "head", frame) for clip in job.clips for frame in range(1, 20)
    )
    assert len(found) == 3
    assert {row["threads"] for rows in found.values() for row in rows} == {str(CONFIG.threads)}
    assert {tuple(read_about(out / clip.folder / "appearance.json")["rendered_on"]) for clip in job.clips} == {("cpu",)}


def test_where_all_frames_are_there_no_process_is_started(planned):
    job, out = planned()
    for clip, camera, frame in job.frames():
        path = job.frame_path(out, clip, camera, frame)
        path.parent.mkdir(exist_ok=True)
        path.touch()
    run_blender(job.folder, out, command=("there is no such program",))


def test_on_a_gpu_one_process_renders_unless_more_are_asked_for(planned):
    job, out = planned(workers=0)
    run_blender(job.folder, out, command=stand_in(device="gpu"))
    assert len(orders(out)) == 1
    for file in out.glob("*.orders"):
        file.unlink()
    job, out = planned(workers=2)
    run_blender(job.folder, out, command=stand_in("wait_for(2)", device="gpu"))
    assert len(orders(out)) == 2


def test_a_crash_of_one_process_is_an_error_with_its_last_words_and_the_end_of_the_others(planned):
    job, out = planned()
    act = "first_of_all() and (wait_for(3), print('out of memory in kernel', file=sys.stderr, flush=True), os.abort())"
    with pytest.raises(BlenderFailed, match=r"(?s)ended by signal 6.*last words:\nout of memory in kernel"):
        run_blender(job.folder, out, command=stand_in(f"{act}; print('fine', file=sys.stderr); time.sleep(60)"))
    assert len(orders(out)) == 3
    assert not any(is_alive(number) for number in orders(out))


def test_a_killed_process_is_an_error_that_says_what_to_do_where_memory_ran_out(planned):
    job, out = planned()
    with pytest.raises(BlenderFailed, match=r"ended by signal 9 .*set workers of rendered_episodes lower"):
        run_blender(job.folder, out, command=stand_in("os.kill(os.getpid(), 9)"))


def test_a_process_that_ends_before_its_work_is_done_is_an_error(planned):
    job, out = planned()
    with pytest.raises(BlenderFailed, match="ended with code 0; its last words"):
        run_blender(job.folder, out, command=stand_in("sys.exit()"))


@pytest.mark.parametrize("to", ["the terminal's group", "the parent alone"])
def test_ctrl_c_ends_all_processes(planned, to):
    job, out = planned()
    parent = subprocess.Popen(
        [
            sys.executable,
            "-c",
            "import signal; from pathlib import Path; from sim1.render.blender import run_blender\n"
            "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # what runs behind a shell's back ignores it
            f"run_blender(Path({str(job.folder)!r}), Path({str(out)!r}), command={stand_in('time.sleep(60)')!r})",
        ],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    until = time.monotonic() + 60
    while len(orders(out)) < 3 and time.monotonic() < until:
        time.sleep(0.05)
    numbers = list(orders(out))
    assert len(numbers) == 3
    (os.killpg if to == "the terminal's group" else os.kill)(parent.pid, signal.SIGINT)
    _, words = parent.communicate(timeout=60)
    assert "KeyboardInterrupt" in words
    assert not any(is_alive(number) for number in numbers)


def test_a_machine_on_which_the_preview_engine_cannot_draw_is_told_what_to_install(planned):
    job, out = planned()
    act = "print('EGL Error (0x300C)', file=sys.stderr, flush=True); os.kill(os.getpid(), 11)"
    with pytest.raises(BlenderFailed, match=r"signal 11: engine 'workbench' finds no OpenGL; apt-get install .*cycles"):
        run_blender(job.folder, out, command=stand_in(act))


@pytest.mark.parametrize("chatter", ["Saved: a.png", "5", "[]", "{}"])
def test_chatter_among_the_progress_lines_is_an_error(planned, chatter):
    job, out = planned()
    with pytest.raises(BlenderFailed, match="no progress line"):
        run_blender(job.folder, out, command=(sys.executable, "-c", f"print({chatter!r})"))


def test_a_missing_system_library_is_named_with_its_package(planned):
    job, out = planned()
    line = json.dumps({"failed": "libXi.so.6: cannot open shared object file: No such file or directory"})
    with pytest.raises(BlenderFailed, match=r"libXi\.so\.6; apt-get install libxi6"):
        run_blender(job.folder, out, command=(sys.executable, "-c", f"print({line!r}); raise SystemExit(3)"))
    assert why_not_loaded("no such module") == "Blender cannot be loaded: no such module"
