"""The laboratory and the tool that is tested on its films know nothing of each other."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def imported(path: Path) -> Iterator[str]:
    """Full names of all that a file imports, anywhere in it."""
    package = list(path.relative_to(ROOT).with_suffix("").parts[:-1])
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = package[: len(package) - node.level + 1] if node.level else []
            base = ".".join([*start, *([node.module] if node.module else [])])
            yield from (f"{base}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("import_module", "__import__")):
            yield ast.unparse(node.args[0]).strip("'\"")


def project_packages() -> set[str]:
    return {path.parent.name for path in ROOT.glob("*/__init__.py")}


def test_the_laboratory_imports_nothing_else_of_the_project():
    files = sorted((ROOT / "benchmarks" / "concealed").rglob("*.py"))
    assert len(files) > 20
    foreign = [
        (path.name, name)
        for path in files
        for name in imported(path)
        if name.split(".")[0] in project_packages() and not name.startswith("benchmarks.concealed")
    ]
    assert foreign == []
    assert {"sim1", "benchmarks"} <= project_packages()


@pytest.mark.parametrize(("package", "least"), [("sim1", 200), ("assets_defs", 20), ("pipeline", 3)])
def test_nothing_of_the_tool_its_commands_or_its_pipeline_imports_the_laboratory_or_a_benchmark(package, least):
    """`sim1 prove` starts the laboratory as a command, as it would any other."""
    files = sorted((ROOT / package).rglob("*.py"))
    assert len(files) >= least
    assert [(path.name, name) for path in files for name in imported(path) if name.split(".")[0] == "benchmarks"] == []
