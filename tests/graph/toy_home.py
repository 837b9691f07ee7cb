"""A home folder with toy stages, and the tools to change its inputs and count what is re-derived."""

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import dagster as dg
import pytest
import yaml
from typer.testing import CliRunner

from assets_defs._regenerate import Report, regenerate
from assets_defs.cli import app
from pipeline import Graph, Home, load_graph

REPOSITORY = Path(__file__).parents[2]
SMALL = {
    "stages": [
        {
            "name": "scan",
            "run": "toy_stages:ingest",
            "version": 1,
            "group": "geometry",
            "per": "garment",
            "sources": {"garment": "data/garments/{garment}.yaml", "scans": "data/scans/{garment}"},
        },
        {
            "name": "mesh",
            "run": "toy_stages:work",
            "version": 1,
            "group": "geometry",
            "per": "garment",
            "needs": ["scan"],
        },
        {
            "name": "model",
            "run": "toy_stages:work",
            "version": 1,
            "group": "motion",
            "per": "garment",
            "needs": ["mesh"],
        },
        {"name": "dataset", "run": "toy_stages:work", "version": 1, "group": "data", "needs": ["model", "mesh"]},
        {"name": "report", "run": "toy_stages:work", "version": 1, "group": "policy", "compares": ["dataset"]},
    ]
}


@dataclass
class Project:
    """A home and what one does with it."""

    root: Path

    @property
    def home(self) -> Home:
        return Home(self.root)

    @property
    def graph(self) -> Graph:
        return load_graph(self.home, "quick")

    def stages(self, **changes: dict[str, Any]) -> None:
        """Write `stages.yaml`, rows changed by name."""
        rows = [{**row, **changes.get(row["name"], {})} for row in SMALL["stages"]]
        (self.root / "pipeline" / "stages.yaml").write_text(yaml.safe_dump({"stages": rows}))

    def add_garment(self, name: str, text: str = "point 0 0 0") -> None:
        (self.root / "data" / "garments" / f"{name}.yaml").write_text(f"title: {name}\n")
        scan = self.root / "data" / "scans" / name / "scan.txt"
        scan.parent.mkdir(parents=True, exist_ok=True)
        scan.write_text(text + f"\nof {name}\n")

    def instance(self) -> dg.DagsterInstance:
        return dg.DagsterInstance.get()

    def run(self, *, jobs: int = 0, profile: str = "quick", **options: Any) -> Report:
        """Regenerate, in this process unless worker processes are asked for."""
        with self.instance() as instance:
            return regenerate(self.home, load_graph(self.home, profile), instance, jobs=jobs, **options)

    def events(self) -> list[str]:
        """Label of every materialization in the event log, oldest first."""
        with self.instance() as instance:
            found = []
            for key in instance.all_asset_keys():
                page = instance.fetch_materializations(dg.AssetRecordsFilter(asset_key=key), limit=5000)
                found += [
                    (
                        record.storage_id,
                        "/".join([*key.path, *([record.partition_key] if record.partition_key else [])]),
                    )
                    for record in page.records
                ]
        return [name for _, name in sorted(found)]

    def command(self, *arguments: str, typed: str | None = None) -> subprocess.CompletedProcess:
        """Run the `sim1` command in this home, within this process: a start of the program takes seconds."""
        environment = dict(os.environ)
        try:
            answer = CliRunner().invoke(app, arguments, input=typed, catch_exceptions=False)
        finally:
            os.environ.clear()
            os.environ.update(environment)
        return subprocess.CompletedProcess(arguments, answer.exit_code, answer.stdout, answer.stderr)

    def process(self, *arguments: str) -> subprocess.CompletedProcess:
        """The same as a person's shell does it."""
        command = [sys.executable, "-c", "from assets_defs.cli import main; main()", *arguments]
        return subprocess.run(command, capture_output=True, text=True, timeout=240)


def enter(root: Path, monkeypatch: pytest.MonkeyPatch) -> Project:
    """Make `root` the home of this process and its children."""
    monkeypatch.setenv("SIM1_HOME", str(root))
    monkeypatch.setenv("DAGSTER_HOME", str(root))
    monkeypatch.setenv("SIM1_PROFILE", "quick")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parent), str(REPOSITORY)]))
    monkeypatch.chdir(root)
    return Project(root)


def storages(folder: str) -> dict[str, Any]:
    """Dagster's own in SQLite, with the events of all runs in one file: a toy need not make a database for each."""
    kinds = {
        "run_storage": ("runs", "SqliteRunStorage"),
        "event_log_storage": ("event_log", "ConsolidatedSqliteEventLogStorage"),
        "schedule_storage": ("schedules", "SqliteScheduleStorage"),
    }
    return {
        name: {"module": f"dagster._core.storage.{module}", "class": kind, "config": {"base_dir": folder}}
        for name, (module, kind) in kinds.items()
    }


def furnish(root: Path) -> None:
    """Two garments and the small graph."""
    (root / "pipeline" / "profiles").mkdir(parents=True)
    (root / "data" / "garments").mkdir(parents=True)
    settings = yaml.safe_load((REPOSITORY / "dagster.yaml").read_text())
    folder = settings.pop("storage")["sqlite"]["base_dir"]
    (root / "dagster.yaml").write_text(yaml.safe_dump(settings | storages(folder)))
    (root / "pipeline" / "profiles" / "quick.yaml").write_text("{}\n")
    project = Project(root)
    project.stages()
    for name in ("towel", "shirt"):
        project.add_garment(name)
