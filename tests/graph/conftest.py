"""Homes with toy stages: one where nothing was made yet, one where everything was."""

import shutil
from pathlib import Path

import pytest
from toy_home import Project, enter, furnish


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Project:
    """A home where nothing was made yet."""
    root = tmp_path / "home"
    furnish(root)
    return enter(root, monkeypatch)


@pytest.fixture(scope="session")
def made_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A home where everything was made, to be copied."""
    root = tmp_path_factory.mktemp("made") / "home"
    furnish(root)
    with pytest.MonkeyPatch.context() as monkeypatch:
        assert len(enter(root, monkeypatch).run().made) == 8
    return root


@pytest.fixture
def made(made_once: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Project:
    """A home where everything was made."""
    shutil.copytree(made_once, tmp_path / "home")
    return enter(tmp_path / "home", monkeypatch)
