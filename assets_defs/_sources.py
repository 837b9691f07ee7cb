"""The files that a person writes: where a stage finds them, and a look at all of them before any work starts."""

import itertools
from collections.abc import Iterable
from pathlib import Path

from assets_defs._config import source_check
from assets_defs._recipe import Key
from pipeline import Graph, Home, Node
from sim1.stage import BadInput


def source(home: Home, node: Node, key: Key, name: str) -> Path | None:
    """Path of the node's source `name`; None: it is optional and not there.

    Raises:
        BadInput: it is not optional and not there, or a link that leads nowhere: what stands in for a lab's recordings
            must not take the place of those on a drive that is not mounted.
    """
    stage = node.stage
    path = home.root / {**stage.sources, **stage.optional_sources}[name].format(garment=key)
    if path.is_symlink() and not path.exists():
        raise BadInput(f"{path}: a link to {path.readlink()}, which is not there; mount its drive, or remove the link")
    if not path.exists() and name in stage.sources:
        raise BadInput(f"{path}: missing; stage {stage.name} needs it (its source {name!r})")
    return path if path.exists() else None


def faults(home: Home, graph: Graph, nodes: set[str], garments: Iterable[str] | None) -> list[str]:
    """A line per file that the work on these nodes and garments (None: all) would stumble over, hours later perhaps."""
    found: dict[str, None] = {}  # a set that keeps its order: several nodes share a file
    for node in (node for id_, node in graph.nodes.items() if id_ in nodes):
        keys = (garments or home.garments()) if node.per else [None]
        for key, name in itertools.product(keys, [*node.stage.sources, *node.stage.optional_sources]):
            try:
                if path := source(home, node, key, name):
                    source_check(node, name)(path)
            except BadInput as error:
                found[home.relative(str(error))] = None
    return list(found)
