"""The diagnosing code, and the laboratory's: every file that such a process can load of its own project, and the libraries that compute for it."""

import ast
import hashlib
import importlib.util
from collections.abc import Iterable, Iterator, Sequence
from importlib.metadata import version
from pathlib import Path

from sim1.proof.ledger import sha256_of
from sim1.stage import BadInput

ENTRY = "assets_defs._diagnose"  # the module by which a campaign starts a diagnosis and a prediction
PACKAGES = ("sim1", "assets_defs", "pipeline")  # followed from there; of others, `LIBRARIES` are told by their versions
DATA = ("*.yaml", "*.jinja")  # beside a module: what it may read
LIBRARIES = ("numpy", "scipy", "numba", "llvmlite", "pandas", "pyarrow")  # that read, compute and write


def code_sha256(root: Path) -> str:
    """SHA-256 over names and hashes of the files of `closure`, and the versions of the libraries.

    Raises:
        BadInput: as `closure`.
    """
    return _sha256((path.relative_to(root).as_posix(), path) for path in closure(root))


def laboratory_sha256(home: Path, command: Sequence[str]) -> str | None:
    """The same of the program that films, as far as it has files here; None where it has none.

    Of `python -m MODULE` below `home` these are the module and what it imports of its own top-level package, of another command the
    files among its words.

    Raises:
        BadInput: a file that is no Python.
    """
    if list(command[1:2]) == ["-m"] and (entry := _started(home, command[2])) is not None:
        paths = closure(home, entry, packages=(entry.split(".")[0],))
        return _sha256((path.relative_to(home).as_posix(), path) for path in paths)
    files = [word for word in command if (home / word).is_file()]
    return _sha256((Path(word).name, home / word) for word in files) if files else None


def _sha256(files: Iterable[tuple[str, Path]]) -> str:
    lines = [f"{sha256_of(path)}  {name}\n" for name, path in files]
    lines += [f"{version(name)}  {name}\n" for name in LIBRARIES]
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def _started(home: Path, module: str) -> str | None:
    """What `python -m` runs of it; None: it is not here."""
    names = (f"{module}.__main__", module)
    return next((name for name in names if _source(home, name) is not None), None)


def closure(root: Path, entry: str = ENTRY, packages: Sequence[str] = PACKAGES) -> tuple[Path, ...]:
    """Files of `packages` that `entry` imports, they import and so on, wherever in them it is said, and the data beside them, sorted.

    `root` holds the packages. An import that is never reached counts too, and of a package that speaks of its `__path__`, to import what
    lies there, every module; another import by a name that is put together as it runs is not seen.

    Raises:
        BadInput: no such entry, or a file that is no Python.
    """
    if _source(root, entry) is None:
        raise BadInput(f"{root}: holds no module {entry}, by which a diagnosis is started; restore the project's files")
    found: dict[str, Path] = {}
    waiting = [entry]
    while waiting:
        name = waiting.pop()
        path = _source(root, name) if name.split(".")[0] in packages and name not in found else None
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
        elif isinstance(node, ast.Name) and node.id == "__path__":
            yield from (f"{name}.{one.stem}" for one in sorted(path.parent.glob("*.py")) if one != path)
