"""What tests of the diagnosis share."""

from dataclasses import replace

import pytest
from small_bundle import empty_bundle, plain_world

from sim1.cloth.precise.scene import prepare
from sim1.mismatch.engine import STEP_S
from sim1.mismatch.search import baseline


@pytest.fixture(scope="module")
def world(bundle):
    """The baseline's world of a module's own `bundle`."""
    return plain_world(bundle)


@pytest.fixture(scope="module")
def scene(bundle):
    """Its first recording at the step of searches."""
    return prepare(bundle, bundle.recordings[0], STEP_S)


@pytest.fixture(scope="module")
def unknowns():
    """A model without any coefficient."""
    return replace(baseline(empty_bundle(motions=2)), nominal=())


@pytest.fixture
def counted_once(monkeypatch):
    """Residuals of a small pool are made for their mean squares, not for how they vary in time; tests that ask for that say so."""
    for module in ("decide", "borne_out"):
        monkeypatch.setattr(f"sim1.mismatch.{module}.overcounted", lambda fit, base: 1.0)
