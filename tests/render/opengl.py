"""The preview engine needs OpenGL: a machine without it says so, else the tests of that engine fail."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from sim1.render.blender import NO_OPENGL, BlenderFailed

KNOWN_WITHOUT = "SIM1_NO_OPENGL"


@contextmanager
def with_opengl() -> Iterator[None]:
    """Fails the test where Blender finds no OpenGL, and skips it where the environment says that there is none."""
    try:
        yield
    except BlenderFailed as error:
        if NO_OPENGL not in str(error):
            raise
        if os.environ.get(KNOWN_WITHOUT) == "1":
            pytest.skip(NO_OPENGL)
        pytest.fail(f"{NO_OPENGL}; {KNOWN_WITHOUT}=1 skips the tests of this engine", pytrace=False)
