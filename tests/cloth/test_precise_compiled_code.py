"""Compiled loops are compiled again when a file changes that they call, and by one process at a time."""

import fcntl
import os
import threading

from sim1.cloth.precise.compiled_code import COMPILED_LAST, forget_stale, one_compiles


def write(path, text="", *, age_s):
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    os.utime(path, (1e9 - age_s, 1e9 - age_s))


def test_code_older_than_any_loop_is_removed_and_newer_stays(tmp_path):
    write(tmp_path / "forces.py", "@njit\n", age_s=10)
    write(tmp_path / "newton.py", "@njit\n", age_s=30)
    write(tmp_path / "scene.py", age_s=0)  # not compiled
    for name, age_s in (
        ("newton.f-1.nbi", 20),
        ("newton.f-1.1.nbc", 20),
        ("scene.cpython-313.pyc", 20),
        ("new.nbi", 5),
    ):
        write(tmp_path / "__pycache__" / name, age_s=age_s)
    forget_stale(tmp_path)
    assert {path.name for path in (tmp_path / "__pycache__").iterdir()} == {"scene.cpython-313.pyc", "new.nbi"}


def test_constants_that_loops_were_compiled_with_count_too(tmp_path):
    write(tmp_path / "arrays.py", age_s=10)
    write(tmp_path / "__pycache__/newton.f-1.nbi", age_s=20)
    forget_stale(tmp_path)
    assert not any((tmp_path / "__pycache__").iterdir())


def test_a_folder_that_was_never_compiled_is_left_alone(tmp_path):
    write(tmp_path / "forces.py", "@njit\n", age_s=10)
    forget_stale(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["forces.py"]


def begins(folder, within_s: float) -> tuple[bool, threading.Thread]:
    """Whether a second user of the loops begins while the first still compiles, and its thread."""
    came, begun = threading.Event(), threading.Event()

    def work():
        came.set()
        with one_compiles(folder):
            begun.set()

    second = threading.Thread(target=work)
    second.start()
    assert came.wait(30)  # a busy machine may let it wait for its first moment, which is no waiting for the other
    return begun.wait(within_s), second


def test_while_nothing_is_compiled_the_second_waits_for_the_first(tmp_path):
    (tmp_path / "__pycache__").mkdir()
    with one_compiles(tmp_path):
        begun, second = begins(tmp_path, within_s=0.3)
        assert not begun
    second.join(timeout=10)
    assert not second.is_alive()


def test_nobody_waits_for_what_is_compiled(tmp_path):
    for name in COMPILED_LAST:
        write(tmp_path / "__pycache__" / f"{name}-1.py313.nbi", age_s=0)
    with (tmp_path / "__pycache__/compiling.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        begun, second = begins(tmp_path, within_s=10)
    assert begun
    second.join(timeout=10)
