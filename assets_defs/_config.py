"""Configs of stages: found by the annotation of the stage's function, checked strictly, dumped whole."""

import functools
import importlib
import typing
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pydantic

from pipeline import Graph, GraphError, Node


@functools.cache
def stage_function(run: str) -> Callable[..., Any]:
    """Import "module:function".

    Raises:
        GraphError: no such module or function.
    """
    module, name = run.split(":")
    try:
        return getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise GraphError(f"stages.yaml: run: {run}: {error}") from error


def check_function(node: Node) -> Callable[..., Any] | None:
    """`check_<stage>` beside the stage's function, where there is one."""
    return getattr(importlib.import_module(node.stage.run.split(":")[0]), f"check_{node.stage.name}", None)


def source_check(node: Node, name: str) -> Callable[[Path], object]:
    """`check_source_<name>` beside the stage's function: raises BadInput at a fault in that file. Nothing where there is none."""
    module = importlib.import_module(node.stage.run.split(":")[0])
    return getattr(module, f"check_source_{name}", lambda path: None)


@functools.cache
def _adapter(run: str) -> pydantic.TypeAdapter:
    hints = typing.get_type_hints(stage_function(run))
    if "config" not in hints:
        raise GraphError(f"stages.yaml: run: {run}: its parameter 'config' has no annotation")
    return pydantic.TypeAdapter(hints["config"])


def config_of(node: Node) -> Any:
    """The config object of a node, defaults filled in.

    Raises:
        GraphError: an unknown key or a wrong value, with stage and key.
    """
    try:
        return _adapter(node.stage.run).validate_python(dict(node.config))
    except pydantic.ValidationError as error:
        issue = error.errors()[0]
        place = ".".join(map(str, issue["loc"]))
        raise GraphError(f"stage {node.id!r}: key {place!r}: {issue['msg']} (got {issue['input']!r})") from None


def resolved_config(node: Node) -> dict[str, Any]:
    """Settings of a node as JSON values, defaults included: a changed default is a changed recipe.

    Left out is what a stage's configuration excludes, as it changes nothing that is made.
    """
    return _adapter(node.stage.run).dump_python(config_of(node), mode="json")


def check_configs(graph: Graph) -> None:
    """Check every config of the graph; raises GraphError at the first fault."""
    for node in graph.nodes.values():
        config_of(node)
