"""Where what stands in a bundle is found, for messages: in its own files, or in those of the lab that were imported."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

DOCUMENT, MESH, ANCHORS = "bundle.yaml", "garment.obj", "anchors.parquet"  # of a bundle; another mesh may be named


@dataclass(frozen=True, kw_only=True)
class Places:
    """What messages name of one file of a bundle."""

    file: Path
    row: Callable[[int], str]  # place of a row of the table, file included


NOT_IMPORTED: Mapping[str, Places] = MappingProxyType({})


@dataclass(frozen=True, kw_only=True)
class BundleFiles:
    """The files of a bundle, and what messages name instead of them."""

    folder: Path
    imported: Mapping[str, Places] = NOT_IMPORTED  # by path in the bundle; a file that is not listed names itself

    def places(self, name: str) -> Places:
        """What messages name of a file."""
        return self.imported.get(name) or own_places(self.folder / name)


def own_places(path: Path) -> Places:
    """Of a file that names itself, and the rows of its table from 0."""
    return Places(file=path, row=lambda row: f"{path}: row {row}")


def stream(recording: str, name: str) -> str:
    """Path in the bundle of a recording's "markers" or "drives"."""
    return f"recordings/{recording}/{name}.parquet"
