"""How a command begins and how it ends badly."""

import os
from typing import TYPE_CHECKING, NoReturn

import typer

if TYPE_CHECKING:
    from pipeline import Graph, Home


def open_home(profile: str | None) -> tuple["Home", "Graph"]:
    """Point Dagster at this project and load its graph; errors end the program with one line."""
    from pipeline import GraphError, Home, load_graph

    home = Home.here()
    os.environ["SIM1_HOME"] = os.environ["DAGSTER_HOME"] = str(home.root)
    if profile:
        os.environ["SIM1_PROFILE"] = profile
    os.chdir(home.root)
    if not (home.root / "dagster.yaml").is_file():
        stop(
            f"{home.root}/dagster.yaml is missing: without it Dagster would use a throw-away instance; restore the file"
        )
    os.environ.setdefault("HF_HUB_OFFLINE", "1")
    try:
        from assets_defs._config import check_configs

        graph = load_graph(home)
        check_configs(graph)
        home.garments()
    except (GraphError, ValueError) as error:
        stop(home.relative(str(error)))
    return home, graph


def stop(message: str) -> NoReturn:
    """End the program with one line."""
    typer.secho(f"sim1: {message}", fg="red", err=True)
    raise typer.Exit(2)
