"""The diagnosing code: every file of this project that the process of a diagnosis can load, and the libraries that compute for it."""

import ast
import hashlib
import importlib.util
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

from sim1.proof.ledger import sha256_of
from sim1.stage import BadInput

ENTRY = "assets_defs._diagnose"  # the module by which a campaign starts a diagnosis and a prediction
PACKAGES = ("sim1", "assets_defs", "pipeline")  # followed; of others, `LIBRARIES` are told by their versions
DATA = ("*.yaml", "*.jinja")  # beside a module: what it may read
LIBRARIES = ("numpy", "scipy", "numba", "llvmlite", "pandas", "pyarrow")  # that read, compute and write


def code_sha256(root: Path) -> str:
    """SHA-256 over names and hashes of the files of `closure`, and the versions of the libraries.

    Raises:
        BadInput: as `closure`.
    """
    lines = [f"{sha256_of(path)}  {path.relative_to(root).as_posix()}\n" for path in closure(root)]
    lines += [f"{version(name)}  {name}\n" for name in LIBRARIES]
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def closure(root: Path, entry: str = ENTRY) -> tuple[Path, ...]:
    """Files that `entry` imports, they import and so on, wherever in them it is said, and the data beside them, sorted.

    `root` holds the packages. An import that is never reached counts too; one by a name that is put together as it runs is not seen.

    Raises:
        BadInput: no such entry, or a file that is no Python.
    """
    if _source(root, entry) is None:
        raise BadInput(f"{root}: holds no module {entry}, by which a diagnosis is started; restore the project's files")
    found: dict[str, Path] = {}
    waiting = [entry]
    while waiting:
        name = waiting.pop()
        path = _source(root, name) if name.split(".")[0] in PACKAGES and name not in found else None
        if path is not None:
            found[name] = path
            waiting += [name.rpartition(".")[0], *_imported(path, name)]
    data = {file for path in found.values() for kind in DATA for file in path.parent.glob(kind)}
    return tuple(sorted({*found.values(), *data}))


def _source(root: Path, name: str) -> Path | None:
    """The file of a module or package; None: there is none, as `name` is that of something in a module."""
    place = root.joinpath(*name.split("."))
    return next((path for path in (place / "__init__.py", place.with_suffix(".py")) if path.is_file()), None)


def _imported(path: Path, name: str) -> Iterator[str]:
    """Names that a file imports; of `from a import b` both `a` and `a.b`, which may be a module."""
    try:
        tree = ast.parse(path.read_bytes())
    except SyntaxError as error:
        raise BadInput(f"{path}: line {error.lineno} is no Python ({error.msg}); mend it") from error
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = importlib.util.resolve_name("." * node.level + (node.module or ""), package)
            yield base
            yield from (f"{base}.{alias.name}" for alias in node.names)
