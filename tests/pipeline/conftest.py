"""A home with one garment and the project's own graph, and the program in it."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from pipeline import Home

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Home:
    """A home with the shipped towel alone and the project's own graph."""
    root = tmp_path_factory.mktemp("smoke") / "home"
    (root / "data" / "garments").mkdir(parents=True)
    shutil.copy(REPOSITORY / "dagster.yaml", root)
    shutil.copy(REPOSITORY / "data" / "prices.yaml", root / "data")
    shutil.copy(REPOSITORY / "data" / "garments" / "towel.yaml", root / "data" / "garments")
    (root / "data" / "tasks").mkdir()
    shutil.copy(REPOSITORY / "data" / "tasks" / "towel.yaml", root / "data" / "tasks")
    for folder in ("scans/towel", "robot", "environment", "policies", "appearance"):
        shutil.copytree(REPOSITORY / "data" / folder, root / "data" / folder)
    return Home(root)


@dataclass(frozen=True)
class Program:
    """The `sim1` command in a home, as a person's shell starts it."""

    home: Home

    def start(self, *arguments: str) -> subprocess.Popen:
        command = [sys.executable, "-c", "from assets_defs.cli import main; main()", *arguments]
        environment = {**os.environ, "SIM1_HOME": str(self.home.root), "PYTHONPATH": str(REPOSITORY), "COLUMNS": "200"}
        environment.pop("SIM1_PROFILE", None)
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        return subprocess.Popen(command, env=environment, cwd=self.home.root, **pipes)

    def __call__(self, *arguments: str) -> subprocess.CompletedProcess:
        with self.start(*arguments) as process:
            out, error = process.communicate(timeout=1500)
        return subprocess.CompletedProcess(arguments, process.returncode, out, error)


@pytest.fixture(scope="module")
def sim1(home: Home) -> Program:
    return Program(home)
