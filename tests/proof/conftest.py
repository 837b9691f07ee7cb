"""A campaign that is done, proved once for all tests that change or read what it left."""

import shutil

import pytest
from proof_stand_ins import DRAG, NULL, campaign

from sim1.proof.prove import prove


@pytest.fixture(scope="session")
def proved(tmp_path_factory):
    folder = tmp_path_factory.mktemp("proved")
    assert [one.right for one in prove(campaign(folder, (DRAG, NULL))).outcomes] == [True, True]
    return folder / "out"


@pytest.fixture
def work(proved, tmp_path):
    """A drag and nothing, filmed, diagnosed and scored: a copy in `tmp_path/out` of the test's own."""
    shutil.copytree(proved, tmp_path / "out")
    return campaign(tmp_path, ())
