"""One factory turns every node of the graph into a Dagster asset."""

import time
from collections.abc import Iterator
from typing import Any

import dagster as dg

from assets_defs._automation import condition
from assets_defs._config import check_function
from assets_defs._digest import digest_json
from assets_defs._metadata import metadata
from assets_defs._produce import NotMade, produce
from assets_defs._recipe import RECIPE_TAG, Snapshot, asset_key
from pipeline import Graph, Home, Node
from sim1.progress import Sink
from sim1.stage import Finding

GARMENTS = dg.DynamicPartitionsDefinition(name="garment")
CHECK = "artifact_is_valid"
PROGRESS_EVERY_S = 5.0


def bind(node: Node, graph: Graph, home: Home) -> dg.AssetsDefinition:
    """The asset of one node: its lineage, checks, retries, pool and automation."""
    checked = check_function(node) is not None
    code_version = f"{node.stage.version}-{digest_json([node.stage.run, dict(node.config)])[:8]}"

    @dg.asset(
        key=asset_key(node),
        deps=[asset_key(graph.nodes[id_]) for id_ in dict.fromkeys(node.needs.values())],
        partitions_def=GARMENTS if node.per else None,
        group_name="ablation" if node.variant else node.stage.group,
        kinds=set(node.stage.kinds),
        description=node.stage.summary + (f" (variant {node.variant})" if node.variant else ""),
        code_version=code_version,
        metadata={"function": node.stage.run, "config": dg.MetadataValue.json(dict(node.config))},
        tags={"sim1/variant": node.variant} if node.variant else None,
        retry_policy=dg.RetryPolicy(max_retries=1, delay=2),
        pool=node.stage.pool,
        check_specs=[dg.AssetCheckSpec(CHECK, asset=asset_key(node), blocking=True)] if checked else None,
        automation_condition=condition(home),
    )
    def run(context: dg.AssetExecutionContext) -> Iterator[Any]:
        key = context.partition_key if node.per else None
        snapshot = Snapshot(context.instance, graph, home)
        try:
            made = produce(home, snapshot, node, key, _sink_of(context))
        except NotMade as error:
            if checked:
                yield _check_result(error.findings, passed=False, description=str(error))
            raise dg.Failure(str(error), allow_retries=error.transient) from error
        yield dg.MaterializeResult(
            data_version=dg.DataVersion(made.record["data_version"]),
            tags={RECIPE_TAG: made.record["recipe"]},
            metadata=metadata(made),
            check_results=[_check_result(made.findings, passed=True)] if checked else [],
        )

    return run


def _check_result(findings: list[Finding], *, passed: bool, description: str | None = None) -> dg.AssetCheckResult:
    warned = [finding for finding in findings if not finding.passed]
    return dg.AssetCheckResult(
        check_name=CHECK,
        passed=passed and not warned,
        # A failed finding that does not block warns: the artifact stands, and a person is told.
        severity=dg.AssetCheckSeverity.WARN if passed else dg.AssetCheckSeverity.ERROR,
        description=description or "; ".join(f"{finding.name}: {finding.detail}" for finding in warned) or None,
        metadata={f"{'ok' if f.passed else 'FAILED'}: {f.name}": f.detail for f in findings},
    )


_sinks: list[Sink] = []


def send_progress_to(sink: Sink) -> None:
    """Also report progress of the assets run in this process to `sink` (the command line's bars)."""
    _sinks.append(sink)


def _sink_of(context: dg.AssetExecutionContext) -> Sink:
    last = time.monotonic()

    def sink(done: float, total: float, what: str) -> None:
        nonlocal last
        for other in _sinks:
            other(done, total, what)
        if (now := time.monotonic()) - last >= PROGRESS_EVERY_S:
            last = now
            context.log.info(f"{what}: {done:g} of {total:g}")

    return sink
