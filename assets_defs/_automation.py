"""Automation on the recipe: a level-triggered condition, a sensor for new garments, a nightly schedule."""

import warnings
from typing import Any

import dagster as dg
from dagster._core.definitions.events import AssetKeyPartitionKey  # no public name in dagster 1.13

from assets_defs._recipe import Snapshot
from pipeline import Graph, Home, load_graph


class RecipeChanged(dg.AutomationCondition):
    """True for artifacts that are stale or missing while all of their parents are fresh.

    Level-triggered: an edit that comes during a run is seen at the next look. An artifact that failed with the recipe in
    force is left alone until the recipe changes or a person starts it.
    """

    def __init__(self, home: Home):
        self._home = home

    @property
    def name(self) -> str:
        return "recipe_changed"

    def evaluate(self, context: dg.AutomationContext) -> dg.AutomationResult:
        view = context.asset_graph_view
        snapshot = _snapshots.at(view.effective_dt, view.instance, self._home)
        node = snapshot.graph.nodes.get("/".join(context.key.path))  # None: it is no more since the UI loaded the graph
        wanted = {
            AssetKeyPartitionKey(context.key, key)
            for key in (snapshot.keys(node) if node else ())
            if _makeable(snapshot, node, key) and (key is None or key in _registered(view.instance))
        }
        subset = view.get_asset_subset_from_asset_partitions(context.key, wanted)
        return dg.AutomationResult(context, true_subset=context.candidate_subset.compute_intersection(subset))


def _makeable(snapshot: Snapshot, node, key) -> bool:
    status = snapshot.status(node, key)
    if status.state not in ("stale", "missing"):
        return False
    return all(snapshot.status(parent, at).state == "fresh" for _, parent, at in snapshot.parents(node, key))


def _registered(instance: dg.DagsterInstance) -> set[str]:
    return set(instance.get_dynamic_partitions("garment"))


class _Snapshots:
    """One reading of graph, event log and sources for all conditions of a tick.

    The graph too: a run reads it when it starts, and by an older one what it made would never be fresh.
    """

    def __init__(self):
        self._of: tuple[Any, Snapshot] | None = None

    def at(self, tick: Any, instance: dg.DagsterInstance, home: Home) -> Snapshot:
        if self._of is None or self._of[0] != (tick, id(instance), home):
            self._of = ((tick, id(instance), home), Snapshot(instance, load_graph(home), home))
        return self._of[1]


_snapshots = _Snapshots()


def condition(home: Home) -> dg.AutomationCondition:
    """Recipe changed, and neither the artifact nor a parent is being made."""
    idle = ~dg.AutomationCondition.in_progress() & ~dg.AutomationCondition.any_deps_in_progress()
    return RecipeChanged(home) & idle


def automation_sensor() -> dg.AutomationConditionSensorDefinition:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", dg.BetaWarning)  # use_user_code_server: the condition is project code
        return dg.AutomationConditionSensorDefinition(
            "regenerate_what_changed",
            target=dg.AssetSelection.all(),
            use_user_code_server=True,
            minimum_interval_seconds=10,
            default_status=dg.DefaultSensorStatus.STOPPED,
            description="Makes every artifact whose recipe changed. Switch it on to have edits followed at once.",
        )


def garment_sensor(home: Home) -> dg.SensorDefinition:
    """Keeps the partitions equal to the files in `data/garments/`."""

    @dg.sensor(minimum_interval_seconds=10, default_status=dg.DefaultSensorStatus.RUNNING)
    def garments_on_disk(context: dg.SensorEvaluationContext) -> dg.SensorResult | dg.SkipReason:
        from assets_defs._factory import GARMENTS

        files, known = set(home.garments()), _registered(context.instance)
        if files == known:
            return dg.SkipReason(f"{len(known)} garments, as in data/garments/")
        changes = []
        if files - known:
            changes.append(GARMENTS.build_add_request(sorted(files - known)))
        if known - files:
            changes.append(GARMENTS.build_delete_request(sorted(known - files)))
        return dg.SensorResult(dynamic_partitions_requests=changes)

    return garments_on_disk


def nightly(graph: Graph, home: Home) -> dg.ScheduleDefinition:
    """At 02:00 UTC, what `sim1 run` does: make everything that is not fresh, by the same recipe."""

    @dg.op(description="Make every artifact that is not fresh; each one appears as a run of its own")
    def regenerate(context: dg.OpExecutionContext) -> None:
        from assets_defs._regenerate import regenerate as make_all

        report = make_all(home, graph, context.instance, notify=context.log.info)
        if report.failed:
            said = "; ".join(f"{name}: {message}" for name, message in report.failed.items())
            raise dg.Failure(said, allow_retries=False)

    @dg.job(description="Make every artifact that is not fresh")
    def regenerate_all() -> None:
        regenerate()

    return dg.ScheduleDefinition(
        name="nightly",
        job=regenerate_all,
        cron_schedule="0 2 * * *",
        default_status=dg.DefaultScheduleStatus.STOPPED,
        description="Incremental regeneration every night at 02:00 UTC",
    )
