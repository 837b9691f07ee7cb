"""Compiled loops are compiled again when a file changes that they call."""

import os

from sim1.cloth.precise.compiled_code import forget_stale


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
