"""`sim1 audit`: every ancestor of an artifact as the event log recorded it, and how a variant's ancestry differs."""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import dagster as dg
from dagster import AssetRecordsFilter, DagsterInstance
from rich.console import Console
from rich.markup import escape
from rich.tree import Tree

from assets_defs._recipe import VERSION_TAG, Key, asset_key, label
from pipeline import Graph, Home, Node


@dataclass(frozen=True, kw_only=True)
class Ancestor:
    """One materialization in an artifact's ancestry."""

    asset: str  # node id
    stage: str
    garment: Key
    data_version: str
    recipe: str
    version: int
    function: str
    config: dict[str, Any]
    seed: int | None
    sources: dict[str, str]  # source name -> digest
    made_from: dict[str, str]  # "input:node[/garment]" -> data version
    seconds: float
    run_id: str


def trace(instance: DagsterInstance, graph: Graph, node: Node, key: Key) -> dict[str, Ancestor]:
    """The latest materialization of an artifact and every materialization that it came from, by "node[/garment]".

    Raises:
        LookupError: it was never made, or an ancestor's record is gone from the event log.
    """
    found: dict[str, Ancestor] = {}

    def visit(node: Node, key: Key, version: str | None, before: int | None) -> None:
        name = label(node, key)
        if name in found:
            return
        found[name], event = _read(instance, node, key, version, before)
        for input_, parent_version in found[name].made_from.items():
            id_, parent_key = _split(graph, input_.split(":", 1)[1])
            visit(graph.nodes[id_], parent_key, parent_version, event)

    visit(node, key, None, None)
    return found


def _read(
    instance: DagsterInstance, node: Node, key: Key, version: str | None, before: int | None
) -> tuple[Ancestor, int]:
    """The latest materialization, of data version `version` and before event `before` where given; and its event."""
    wanted = AssetRecordsFilter(
        asset_key=asset_key(node), asset_partitions=[key] if key else None, before_storage_id=before
    )
    for event in _history(instance, wanted):
        materialization = event.asset_materialization
        tags = materialization.tags or {}
        if version is None or tags.get(VERSION_TAG) == version:
            record = materialization.metadata["record"].value
            parts = record["parts"]
            ancestor = Ancestor(
                asset=node.id,
                stage=node.stage.name,
                garment=key,
                data_version=tags[VERSION_TAG],
                recipe=record["recipe"],
                version=parts["version"],
                function=parts["function"],
                config=parts["config"],
                seed=parts["config"].get("seed"),
                sources=parts["sources"],
                made_from=parts["made_from"],
                seconds=record["seconds"],
                run_id=event.run_id,
            )
            return ancestor, event.storage_id
    raise LookupError(
        f"{label(node, key)}: " + ("was never made; sim1 run" if version is None else f"no record of version {version}")
    )


def _history(instance: DagsterInstance, wanted: AssetRecordsFilter) -> Iterator[dg.EventLogRecord]:
    cursor = None
    while True:
        page = instance.fetch_materializations(wanted, limit=50, cursor=cursor)
        yield from page.records
        if not page.has_more:
            return
        cursor = page.cursor


def _split(graph: Graph, name: str) -> tuple[str, Key]:
    """Split VARIANT/STAGE/GARMENT into node id and garment."""
    if name in graph.nodes:
        return name, None
    id_, _, key = name.rpartition("/")
    if id_ not in graph.nodes:
        raise LookupError(f"{name}: no such asset; there are {sorted(graph.nodes)}")
    return id_, key


def differences(one: dict[str, Ancestor], other: dict[str, Ancestor]) -> list[dict[str, Any]]:
    """Where two ancestries differ, stage by stage: settings and data versions, None where a side has no such artifact.

    `content` of a row: "differs", "same" (only the recipe differs), or "only in one". Rows of the same content come last.
    """
    left = {(ancestor.stage, ancestor.garment): ancestor for ancestor in one.values()}
    right = {(ancestor.stage, ancestor.garment): ancestor for ancestor in other.values()}
    rows = []
    for stage, garment in dict.fromkeys([*left, *right]):
        here, there = left.get((stage, garment)), right.get((stage, garment))
        if here is None or there is None or (here.data_version, here.recipe) != (there.data_version, there.recipe):
            rows.append(
                {
                    "artifact": f"{stage}/{garment}" if garment else stage,
                    "content": _content(here, there),
                    "settings": _settings(here, there),
                    "data_version": [here and here.data_version[:8], there and there.data_version[:8]],
                }
            )
    return sorted(rows, key=lambda row: row["content"] == "same")


def _content(here: Ancestor | None, there: Ancestor | None) -> str:
    if here is None or there is None:
        return "only in one"
    return "same" if here.data_version == there.data_version else "differs"


def _settings(here: Ancestor | None, there: Ancestor | None) -> dict[str, list[Any]]:
    if here is None or there is None:
        return {}
    return {
        key: [here.config.get(key), there.config.get(key)]
        for key in sorted({*here.config, *there.config})
        if here.config.get(key) != there.config.get(key)
    }


def print_audit(home: Home, graph: Graph, asset: str, against: str | None, *, as_json: bool) -> None:
    """Print the ancestry of `asset`, or its difference from that of the same stage in variant `against`.

    Raises:
        LookupError: no such artifact or variant, a garment is missing or too much, or a record is gone.
    """
    id_, key = _split(graph, asset)
    node = graph.nodes[id_]
    if node.per and not key:
        raise LookupError(f"{id_}: every garment has its own; sim1 audit {id_}/GARMENT, of {home.garments()}")
    if key and not node.per:
        raise LookupError(f"{asset}: {id_} exists once for all garments; sim1 audit {id_}")
    with dg.DagsterInstance.get() as instance:
        ancestry = trace(instance, graph, node, key)
        if against is not None:
            other_id = f"{against}/{node.stage.name}"
            if other_id not in graph.nodes:
                raise LookupError(
                    f"variant {against!r} does not change {node.stage.name!r}: it is the base asset itself"
                )
            rows = differences(ancestry, trace(instance, graph, graph.nodes[other_id], key))
            _print_differences(rows, asset, other_id, as_json=as_json)
            return
    if as_json:
        listed = {name: asdict(ancestor) for name, ancestor in ancestry.items()}
        print(json.dumps({"schema": "sim1.audit/1", "asset": asset, "ancestry": listed}, indent=1))
        return
    Console().print(_tree(graph, ancestry, asset), highlight=False)


def _tree(graph: Graph, ancestry: dict[str, Ancestor], name: str, drawn: set[str] | None = None) -> Tree:
    drawn = drawn if drawn is not None else set()
    own = ancestry[name]
    seed = f" seed {own.seed}" if own.seed is not None else ""
    tree = Tree(f"[bold]{name}[/bold] data {own.data_version[:8]} version {own.version}{seed} ({own.seconds:.1f} s)")
    if name in drawn:
        tree.label += " (above)"
        return tree
    drawn.add(name)
    settings = {key: value for key, value in own.config.items() if key != "seed"}
    if settings:
        tree.add("[dim]" + ", ".join(f"{key}={value}" for key, value in settings.items()))
    for source, digest in own.sources.items():
        tree.add(f"[cyan]source {source}[/cyan] {digest[:8]}")
    for input_ in own.made_from:
        tree.add(_tree(graph, ancestry, input_.split(":", 1)[1], drawn))
    return tree


def _print_differences(rows: list[dict[str, Any]], one: str, other: str, *, as_json: bool) -> None:
    if as_json:
        print(json.dumps({"schema": "sim1.audit.difference/1", "one": one, "other": other, "rows": rows}, indent=1))
        return
    console = Console(highlight=False, soft_wrap=True)
    changed, same = ([row for row in rows if (row["content"] == "same") is equal] for equal in (False, True))
    console.print(f"{one} against {other}: the content of {len(changed)} artifacts differs")
    for row in changed:
        versions = " -> ".join(version or "none" for version in row["data_version"])
        console.print(escape(f"  {row['artifact']}: {versions}  {_changes(row)}".rstrip()))
    if same:
        console.print(f"{len(same)} more have another recipe and the same content:")
    for row in same:
        console.print(escape(f"  {row['artifact']}  {_changes(row)}".rstrip()))


def _changes(row: dict[str, Any]) -> str:
    return "; ".join(f"{key}: {one} -> {other}" for key, (one, other) in row["settings"].items())
