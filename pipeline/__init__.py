"""What is made from what, as data: stages, profiles, garments, ablations. Imports neither dagster nor sim1."""

from pipeline.graph import Graph, GraphError, Node, Stage, load_graph
from pipeline.home import Home

__all__ = ["Graph", "GraphError", "Home", "Node", "Stage", "load_graph"]
