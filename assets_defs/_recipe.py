"""Is an artifact what its recipe would make now? Decided by content, for command line, schedule and automation alike.

Recipe: stage version, function, config, digests of the sources, and the data version of every parent and garment. Its
digest is a tag of each materialization. Dagster's own staleness is not used: a fan-in of 100 partitions or more is
always called fresh by it, and its eager condition ignores data versions (dagster 1.13.27).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import dagster as dg
from dagster import AssetRecordsFilter, DagsterEventType, DagsterInstance

from assets_defs._config import resolved_config
from assets_defs._digest import digest_json, digest_path
from assets_defs._store import place
from pipeline import Graph, Home, Node

RECIPE_TAG = "sim1/recipe"
VERSION_TAG = "dagster/data_version"

type Key = str | None  # a garment, or None for a joint artifact
type State = Literal["fresh", "stale", "missing", "waiting", "failed"]


def asset_key(node: Node) -> dg.AssetKey:
    return dg.AssetKey(node.id.split("/"))


def label(node: Node, key: Key) -> str:
    """What a person calls an artifact: stage/garment, a variant's name in front."""
    return f"{node.id}/{key}" if key else node.id


@dataclass(frozen=True)
class Status:
    """State of one artifact and the reason for it."""

    state: State
    why: str = ""


class Snapshot:
    """The event log's latest recipe and data version of every artifact, read with two queries per asset."""

    def __init__(self, instance: DagsterInstance, graph: Graph, home: Home):
        self.graph, self.home = graph, home
        self.garments = home.garments()
        self._read: dict[int, dict[str, str]] = {}  # event id -> tags
        self._tags = {id_: self._latest(instance, node) for id_, node in graph.nodes.items()}
        self._status: dict[tuple[str, Key], Status] = {}

    def _latest(self, instance: DagsterInstance, node: Node) -> dict[Key, dict[str, str]]:
        key, materialized = asset_key(node), DagsterEventType.ASSET_MATERIALIZATION
        if node.per is None:
            newest = instance.fetch_materializations(AssetRecordsFilter(asset_key=key), limit=1).records
            return {None: dict(newest[0].asset_materialization.tags or {})} if newest else {}
        ids = instance.event_log_storage.get_latest_storage_id_by_partition(key, materialized)
        if unread := [id_ for id_ in ids.values() if id_ not in self._read]:
            wanted = AssetRecordsFilter(asset_key=key, storage_ids=unread)
            for record in instance.fetch_materializations(wanted, limit=len(unread)).records:
                self._read[record.storage_id] = dict(record.asset_materialization.tags or {})
        return {partition: self._read[id_] for partition, id_ in ids.items()}

    def refresh(self, instance: DagsterInstance, id_: str) -> None:
        """Read one node again after it was made."""
        self._tags[id_] = self._latest(instance, self.graph.nodes[id_])
        self._status.clear()

    def keys(self, node: Node) -> list[Key]:
        return list(self.garments) if node.per else [None]

    def artifacts(self) -> Iterator[tuple[Node, Key]]:
        """Every artifact of the graph, parents before children."""
        for node in self.graph.nodes.values():
            for key in self.keys(node):
                yield node, key

    def parents(self, node: Node, key: Key) -> Iterator[tuple[str, Node, Key]]:
        """Input name, node and garment of everything that an artifact is made from."""
        for name, id_ in node.needs.items():
            parent = self.graph.nodes[id_]
            for parent_key in [key] if parent.per == node.per else self.keys(parent):
                yield name, parent, parent_key

    def version(self, node: Node, key: Key) -> str | None:
        """Data version of the latest materialization."""
        return self._tags[node.id].get(key, {}).get(VERSION_TAG)

    def parts(self, node: Node, key: Key) -> dict[str, Any] | None:
        """What the artifact would be made from now; None while a parent does not exist."""
        made_from = {}
        for name, parent, parent_key in self.parents(node, key):
            version = self.version(parent, parent_key)
            if version is None:
                return None
            made_from[f"{name}:{label(parent, parent_key)}"] = version
        sources = {}
        for name, path in node.stage.sources.items():
            at = self.home.root / path.format(garment=key)
            sources[name] = digest_path(at) if at.exists() else "missing"
        for name, path in node.stage.optional_sources.items():
            at = self.home.root / path.format(garment=key)
            sources[name] = digest_path(at) if at.exists() else "absent"
        return {
            "version": node.stage.version,
            "function": node.stage.run,
            "config": resolved_config(node),
            "sources": sources,
            "made_from": made_from,
        }

    def status(self, node: Node, key: Key) -> Status:
        """Fresh, stale and why, missing, waiting for a parent, or failed with this very recipe."""
        if (node.id, key) not in self._status:
            self._status[node.id, key] = self._judge(node, key)
        return self._status[node.id, key]

    def _judge(self, node: Node, key: Key) -> Status:
        for _, parent, parent_key in self.parents(node, key):
            if (above := self.status(parent, parent_key).state) != "fresh":
                state = "waiting" if self.version(node, key) else "missing"
                return Status(state, f"{label(parent, parent_key)} is {above}")
        parts = self.parts(node, key)
        recipe = digest_json(parts)
        at = place(self.home, node, key)
        failed = at.failed()
        if failed and failed["recipe"] == recipe:
            return Status("failed", failed["message"])
        tags = self._tags[node.id].get(key)
        if tags is None:
            return Status("missing", "never made")
        record = at.record()
        if record is None:
            return Status("missing", "its files are gone")
        if tags.get(RECIPE_TAG) != recipe:
            return Status("stale", _difference(record["parts"], parts))
        if record["recipe"] != recipe or record["data_version"] != tags.get(VERSION_TAG):
            return Status("stale", "the files are not those of the last recorded run")
        if damage := at.damage(record, thorough=False):
            return Status("stale", f"damaged: {damage}")
        return Status("fresh")


def _difference(before: dict[str, Any], now: dict[str, Any]) -> str:
    """Which part of a recipe changed, for a person."""
    for part in ("version", "function"):
        if before.get(part) != now[part]:
            return f"{part} changed from {before.get(part)} to {now[part]}"
    for part, noun in (("sources", "source"), ("config", "setting"), ("made_from", "parent")):
        old, new = before.get(part, {}), now[part]
        changed = sorted(name for name in {*old, *new} if old.get(name) != new.get(name))
        if changed:
            shown = ", ".join(name.split(":")[-1] for name in changed[:3])
            more = f" and {len(changed) - 3} more" if len(changed) > 3 else ""
            values = f" from {old.get(changed[0])} to {new.get(changed[0])}" if part == "config" else ""
            return f"{noun} {shown}{more} changed{values}"
    return "its last run was not recorded"
