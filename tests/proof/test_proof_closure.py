"""Which code is called the one that diagnosed: all that the process of a diagnosis can load, and nothing else."""

import pytest

from pipeline.home import REPOSITORY
from sim1.proof import closure as rule
from sim1.proof.closure import closure, code_sha256, laboratory_sha256
from sim1.stage import BadInput

FILES = {
    "assets_defs/__init__.py": "",
    "assets_defs/_diagnose.py": "def run():\n    from sim1.deep import far\n",
    "assets_defs/cli.py": "import sim1.other\n",
    "sim1/__init__.py": "",
    "sim1/other.py": "other = 1\n",
    "sim1/deep/__init__.py": "from .near import name\n",
    "sim1/deep/far.py": "import numpy, sim1.deep.farther as f, sim1.listed\nfrom json import loads\n",
    "sim1/deep/farther.py": "",
    "sim1/deep/near.py": "name = 1\n",
    "sim1/deep/limits.yaml": "a: 1\n",
    "sim1/deep/page.jinja": "",
    "sim1/deep/notes.md": "",
    "sim1/deep/alone.py": "",
    "sim1/listed/__init__.py": "from pkgutil import iter_modules\nnames = list(iter_modules(__path__))\n",
    "sim1/listed/one.py": "",
}
LOADED = set(FILES) - {"assets_defs/cli.py", "sim1/other.py", "sim1/deep/notes.md", "sim1/deep/alone.py"}


@pytest.fixture
def root(tmp_path):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_imports_are_followed_wherever_they_stand_and_data_beside_a_module_belongs_to_it(root):
    assert {path.relative_to(root).as_posix() for path in closure(root)} == LOADED


def test_the_hash_sees_names_and_contents_of_these_files_and_of_no_other(root):
    first = code_sha256(root)
    for name in FILES:
        (root / name).write_text(FILES[name] + "\n")
        assert (code_sha256(root) != first) == (name in LOADED), name
        (root / name).write_text(FILES[name])
    assert code_sha256(root) == first


def test_another_version_of_what_computes_is_other_code(root, monkeypatch):
    first = code_sha256(root)
    monkeypatch.setattr(rule, "version", lambda name: "0.0" if name == "scipy" else "1.0")
    changed = code_sha256(root)
    monkeypatch.setattr(rule, "version", lambda name: "1.0")
    assert len({first, changed, code_sha256(root)}) == 3


def test_a_file_that_is_no_python_and_a_missing_entry_are_named(root):
    (root / "sim1/deep/far.py").write_text("a = 1\ndef")
    with pytest.raises(BadInput, match=r"far\.py: line 2 is no Python"):
        closure(root)
    (root / "assets_defs/_diagnose.py").unlink()
    with pytest.raises(BadInput, match=r"holds no module assets_defs\._diagnose"):
        closure(root)


def test_of_this_project_the_diagnosing_rooms_are_in_it_and_those_that_score_or_make_data_are_not():
    rooms = {path.relative_to(REPOSITORY).parts[:2] for path in closure(REPOSITORY)}
    assert {("sim1", room) for room in ("mismatch", "cloth", "recording", "stage.py", "child_process.py")} < rooms
    others = ("proof", "policy", "render", "dataset", "motion", "robot", "scan", "validity")
    assert not rooms & {("sim1", room) for room in others}
    assert ("assets_defs", "cli.py") not in rooms
    names = {path.name for path in closure(REPOSITORY)}
    assert {"thresholds.yaml", "diagnosis.html.jinja"} < names


def test_the_laboratory_has_a_hash_of_its_own_package_or_of_the_files_among_its_words(tmp_path):
    files = {
        "benchmarks/__init__.py": "",
        "benchmarks/dark/__init__.py": "",
        "benchmarks/dark/__main__.py": "from benchmarks.dark import jet\nimport sim1.deep.far\n",
        "benchmarks/dark/jet.py": "",
        "benchmarks/other.py": "",
        "sim1/deep/far.py": "",
        "lab.sh": "true",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    package, script = ("python", "-m", "benchmarks.dark"), ("./lab.sh", "--bright")
    first = {command: laboratory_sha256(tmp_path, command) for command in (package, script)}
    for name in files:
        (tmp_path / name).write_text(files[name] + "\n")
        changed = {command for command in first if laboratory_sha256(tmp_path, command) != first[command]}
        assert changed == ({package} if name in list(files)[:4] else {script} if name == "lab.sh" else set()), name
        (tmp_path / name).write_text(files[name])
    assert laboratory_sha256(tmp_path, ("python", "-m", "somewhere.else")) is None
    assert laboratory_sha256(tmp_path, ("studio", "--bright")) is None


def test_the_laboratory_of_this_project_has_a_hash_that_sees_its_effects():
    paths = closure(REPOSITORY, "benchmarks.concealed.__main__", packages=("benchmarks",))
    assert {"effects", "motions"} & {path.parent.name for path in paths}
    assert laboratory_sha256(REPOSITORY, ("python", "-m", "benchmarks.concealed")) is not None
