"""What tests of verdicts share."""

from dataclasses import replace

import pytest
from small_bundle import empty_bundle

from sim1.mismatch.search import baseline


@pytest.fixture(scope="module")
def unknowns():
    """A model without any coefficient."""
    return replace(baseline(empty_bundle(motions=2)), nominal=())


@pytest.fixture
def counted_once(monkeypatch):
    """Residuals of a small pool are made for their mean squares, not for how they vary in time; tests that ask for that say so."""
    monkeypatch.setattr("sim1.mismatch.decide.overcounted", lambda fit, base: 1.0)
