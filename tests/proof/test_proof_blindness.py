"""The diagnosis itself, in processes that tell every file that Python opens: of a campaign it sees its bundle and where it writes."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from small_bundle import empty_bundle, filmed

from pipeline.home import REPOSITORY
from sim1.proof.closure import ENTRY, closure
from sim1.recording.bundle import write_bundle

WATCH = """
import os, sys
told = os.open(os.environ["WATCH_TOLD"], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
campaign, allowed = os.environ["WATCH_CAMPAIGN"], os.environ["WATCH_ALLOWED"].split(os.pathsep)
def within(path, folder):
    return path == folder or path.startswith(folder + os.sep)
def watch(event, args):
    if event not in ("open", "os.listdir", "os.scandir") or isinstance(args[0], int):
        return
    path = os.path.abspath(os.fsdecode(args[0] or "."))  # links need no following: there are none in a campaign
    os.write(told, (path + chr(10)).encode())
    if within(path, campaign) and not any(within(path, one) for one in allowed):
        raise PermissionError("not to be looked at: " + path)
sys.addaudithook(watch)
"""
BRIEFLY = f"from {ENTRY} import diagnose; from pathlib import Path; diagnose(Path({{0!r}}), Path({{1!r}}), budget_minutes=0.01)"
PEEKS = "import os; bundle = {0!r}; "
PEEKING = {
    "opened": "open(bundle + '/../../answers/case_001.json')",
    "listed": "os.listdir(bundle + '/..')",
    "walked": "list(os.scandir(bundle + '/../../unseen'))",
    "in a process of its own": "import subprocess, sys; "
    "subprocess.run([sys.executable, '-c', 'import sys; open(sys.argv[1] + \"/../../answers/case_001.json\")', bundle], check=True)",
}


@pytest.fixture(scope="module")
def places(tmp_path_factory):
    """A campaign's folders, with a bundle that is quickly simulated."""
    root = tmp_path_factory.mktemp("campaign")
    write_bundle(root / "bundles" / "case_001", filmed(empty_bundle(motions=2, duration_s=1.2), air_normal=3.0))
    for name in ("answers", "unseen", "found"):
        (root / name).mkdir()
    (root / "answers" / "case_001.json").write_text("air_drag")
    return root


def watched(program: str, root: Path, tmp_path: Path) -> tuple[int, str, set[Path]]:
    """Exit code and words of a program in Python, and what it and every process that it starts opened."""
    (tmp_path / "watch").mkdir()
    (tmp_path / "watch" / "sitecustomize.py").write_text(WATCH)
    (tmp_path / "empty").mkdir()
    bundle, out = root / "bundles" / "case_001", root / "found" / ".case_001.1"
    surroundings = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join((str(tmp_path / "watch"), str(REPOSITORY))),
        "WATCH_TOLD": str(tmp_path / "told"),
        "WATCH_CAMPAIGN": str(root),
        "WATCH_ALLOWED": os.pathsep.join((str(bundle), str(out))),
    }
    command = [sys.executable, "-P", "-c", program.format(str(bundle), str(out))]
    done = subprocess.run(
        command, cwd=tmp_path / "empty", env=surroundings, capture_output=True, text=True, check=False
    )
    opened = {Path(line) for line in (tmp_path / "told").read_text().splitlines()}
    return done.returncode, done.stdout + done.stderr, opened


@pytest.mark.parametrize("way", PEEKING)
def test_whoever_looks_at_the_answers_is_caught(places, tmp_path, way):
    code, said, _ = watched(PEEKS + PEEKING[way], places, tmp_path)
    assert code
    assert "not to be looked at" in said


@pytest.fixture(scope="module")
def diagnosed(places, tmp_path_factory):
    """A whole diagnosis, from reading to its report, that searches no longer than it must."""
    return watched(BRIEFLY, places, tmp_path_factory.mktemp("diagnosed"))


def test_the_diagnosis_opens_nothing_of_a_campaign_but_its_bundle_and_where_it_writes(places, diagnosed):
    code, said, opened = diagnosed
    assert code == 0, said
    seen = {path.relative_to(places).parts[:2] for path in opened if path.is_relative_to(places)}
    assert seen == {("bundles", "case_001"), ("found", ".case_001.1")}
    assert json.loads((places / "found" / ".case_001.1" / "verdict.json").read_text())["verdict"] == "unknown"


def test_all_code_and_data_of_the_project_that_it_loads_is_in_the_hash_of_the_diagnosing_code(diagnosed):
    ours = {path for path in diagnosed[2] if path.is_relative_to(REPOSITORY)}
    loaded = {_source(path) for path in ours if not path.is_relative_to(REPOSITORY / ".venv")}
    files = {path for path in loaded if path.suffix in (".py", ".yaml", ".jinja")}
    assert len(files) > 80
    assert files <= set(closure(REPOSITORY))


def _source(path: Path) -> Path:
    """Of `__pycache__/a.cpython-313.pyc`, `a.py`; also while it is written, under a name with digits behind it."""
    if path.parent.name == "__pycache__" and ".pyc" in path.name:
        return path.parent.parent / f"{path.name.split('.')[0]}.py"
    return path
