"""`sim1 generate`: Algorithm 1 from the artifacts in the store, until so many episodes are accepted."""

import dataclasses
import os
import time
from pathlib import Path
from typing import Annotated, Any

import typer

from assets_defs._open import open_home, stop
from assets_defs._progress import bar


def generate(
    garment: Annotated[str, typer.Argument(help="A garment whose artifacts are made, up to valid_trajectories.")],
    target: Annotated[int, typer.Option(min=1, help="Episodes that pass judge, state rules and video discriminator.")],
    out: Annotated[
        Path | None, typer.Option(help="Folder; one that was begun goes on. Default: build/generated/GARMENT.")
    ] = None,
    workers: Annotated[int, typer.Option(min=1, help="Processes; how many has no influence on what is made.")] = (
        os.cpu_count() or 1
    ),
    seed: Annotated[
        int,
        typer.Option(min=0, help="Of the attempts; another than candidate_trajectories has, from which filters learn."),
    ] = 1,
    variant: Annotated[str | None, typer.Option(help="Ablation variant whose artifacts are used.")] = None,
) -> None:
    """Make episodes until enough are accepted; every attempt is kept with what became of it.

    Ctrl-C or a crash loses the attempts under way, no others. Several such commands may work in one folder.
    """
    from assets_defs._store import StoreError
    from sim1.crew import CrewDied
    from sim1.stage import BadInput

    asked = out and out.resolve()
    home, graph = open_home(None)
    folder = asked or home.root / "build" / "generated" / garment
    try:
        inputs, nodes, versions = given(home, graph, garment, variant, seed)
        from assets_defs._config import config_of
        from sim1.motion.algorithm import generate_until

        configs = (dataclasses.replace(config_of(nodes[0]), seed=seed), config_of(nodes[1]))
        began = time.monotonic()
        with bar(target) as show:

            def tell(rows: dict[str, dict[str, Any]]) -> None:
                accepted = sum(row["accepted"] for row in rows.values())
                show(min(accepted, target), f"{accepted} of {target} accepted, {len(rows)} attempts")

            code = code_of(nodes)
            rows = generate_until(inputs, garment, variant, configs, versions, code, folder, target, workers, tell)
    except (BadInput, StoreError, CrewDied) as error:
        stop(home.relative(str(error)))
    except KeyboardInterrupt:
        typer.secho("stopped; the same command goes on where it was", err=True)
        raise typer.Exit(130) from None
    _print(rows, target, time.monotonic() - began, home.relative(str(folder)))


def given(
    home, graph, garment: str, variant: str | None, seed: int
) -> tuple[dict[str, dict[str, Path]], list[Any], dict[str, str]]:
    """Inputs of both stages, their nodes, and the data version of each input.

    Raises:
        BadInput: no such garment or variant, or a seed whose attempts the filters know.
        StoreError: an artifact is missing or damaged.
    """
    from assets_defs._store import verified
    from sim1.stage import BadInput

    if garment not in home.garments():
        raise BadInput(f"{garment}: there is no data/garments/{garment}.yaml; there are {home.garments()}")
    if variant not in (None, *graph.variants):
        raise BadInput(f"--variant {variant}: there are {sorted(graph.variants)}")
    stages = ("candidate_trajectories", "valid_trajectories")
    nodes = [graph.nodes.get(f"{variant}/{name}") or graph.nodes[name] for name in stages]
    refuse_seed_learned_from(home, nodes[0], garment, seed)
    needed = {name: id_ for node in nodes for name, id_ in node.needs.items() if name not in stages}
    inputs, versions = {}, {}
    for name, id_ in needed.items():
        path, record = verified(home, graph.nodes[id_], garment)
        inputs[name], versions[name] = {garment: path}, record["data_version"]
    return inputs, nodes, versions


def refuse_seed_learned_from(home, node: Any, garment: str, seed: int) -> None:
    """Filters that judge the very attempts they were trained on would pass for better than they are.

    Raises:
        BadInput: the stage has this seed, by its config or by that of the artifact in the store.
    """
    from assets_defs._config import config_of
    from assets_defs._store import place
    from sim1.stage import BadInput

    made = place(home, node, garment).record()
    known = {f"{node.id} in the profile in force": config_of(node).seed}
    if made:
        known[f"{node.id}/{garment} in the store"] = made["parts"]["config"].get("seed")
    for where, other in known.items():
        if other == seed:
            raise BadInput(
                f"--seed {seed}: {where} has seed {other} too, and rules and video discriminator have learned from these very "
                f"attempts; give --seed {next(n for n in range(1, 9) if n not in known.values())}, or any other"
            )


def code_of(nodes: list[Any]) -> dict[str, str]:
    """Stage -> its function and version: other code would make other episodes from the same inputs."""
    return {node.stage.name: f"{node.stage.run}, version {node.stage.version}" for node in nodes}


def _print(rows: list[dict[str, Any]], target: int, seconds: float, where: str) -> None:
    from sim1.statistics import describe_share
    from sim1.validity.deciding import compared_filters

    accepted = sum(row["accepted"] for row in rows)
    print(f"accepted: {describe_share(accepted, len(rows))} attempts in {where}; {seconds:.0f} s this time")
    failures: dict[str, int] = {}
    for row in rows:
        if row["failure"]:
            failures[row["failure"]] = failures.get(row["failure"], 0) + 1
    for name, count in sorted(failures.items(), key=lambda item: -item[1]):
        print(f"  {name}: {count}")
    for found in compared_filters(rows):
        print(f"  {found['filter']}, against the judge: precision {found['precision']}; recall {found['recall']}")
    if accepted < target:
        typer.secho(
            f"sim1: {accepted} of {target} after {len(rows)} attempts, the limit; see attempts.png", fg="red", err=True
        )
        raise typer.Exit(1)
