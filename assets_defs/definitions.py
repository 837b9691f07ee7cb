"""The Dagster code location: every node of the graph as an asset, with automation."""

import dagster as dg

from assets_defs._automation import automation_sensor, garment_sensor, nightly
from assets_defs._config import check_configs
from assets_defs._factory import bind
from pipeline import Graph, Home, load_graph


def bind_all(graph: Graph, home: Home) -> dict[str, dg.AssetsDefinition]:
    """The asset of every node, by node id.

    Raises:
        GraphError: a config is at fault.
    """
    check_configs(graph)
    return {node.id: bind(node, graph, home) for node in graph.nodes.values()}


def definitions(graph: Graph, home: Home) -> dg.Definitions:
    """Assets, sensors and schedule of a graph."""
    return dg.Definitions(
        assets=list(bind_all(graph, home).values()),
        sensors=[automation_sensor(), garment_sensor(home)],
        schedules=[nightly(graph, home)],
    )


@dg.definitions
def defs() -> dg.Definitions:
    """What Dagster loads: the graph of the home at hand, in the profile in force."""
    home = Home.here()
    return definitions(load_graph(home), home)
