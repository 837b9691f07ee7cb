"""Where there is no OpenGL, tests of the preview engine are left out on request alone."""

import pytest
from opengl import with_opengl

from sim1.render.blender import NO_OPENGL, BlenderFailed


def rendering(error: str) -> None:
    with with_opengl():
        raise BlenderFailed(error)


@pytest.mark.parametrize("said", [None, "", "0"])
def test_without_opengl_a_test_fails_and_says_what_to_install_or_to_set(monkeypatch, said):
    monkeypatch.delenv("SIM1_NO_OPENGL", raising=False)
    if said is not None:
        monkeypatch.setenv("SIM1_NO_OPENGL", said)
    with pytest.raises(pytest.fail.Exception, match=r"apt-get install libegl1 .*; SIM1_NO_OPENGL=1 skips the tests"):
        rendering(f"Blender's process was ended by signal 11: {NO_OPENGL}")


def test_a_machine_that_is_known_to_have_no_opengl_skips_it(monkeypatch):
    monkeypatch.setenv("SIM1_NO_OPENGL", "1")
    with pytest.raises(pytest.skip.Exception, match="finds no OpenGL"):
        rendering(f"Blender's process was ended by signal 11: {NO_OPENGL}")


def test_another_failure_of_blender_is_never_skipped(monkeypatch):
    monkeypatch.setenv("SIM1_NO_OPENGL", "1")
    with pytest.raises(BlenderFailed, match="ended by signal 9"):
        rendering("Blender's process was ended by signal 9")
