"""`sim1 replay`: an episode simulated again from what is recorded of it."""

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from assets_defs._open import open_home, stop

STAGES = ("seed_demos", "real_demos", "candidate_trajectories")  # whose episodes are simulated; later ones are copies
CELL = ("garment_mesh", "scene")  # what commands need to be driven again, beside the episode's own record


def replay(
    episode: Annotated[Path, typer.Argument(help="Folder with episode.npz: of the store, or of `sim1 generate`.")],
    from_seed: Annotated[
        bool, typer.Option("--from-seed", help="Draw and plan a generated episode anew too, not its commands alone.")
    ] = False,
) -> None:
    """Simulate an episode again and compare every number with the recorded one: the same bytes on the CPU."""
    from assets_defs._store import StoreError
    from sim1.stage import BadInput

    folder = episode.resolve()
    home, graph = open_home(None)
    try:
        origin = _origin(folder)
        from sim1.motion.replay import replay_commands, replay_seed

        if from_seed:
            inputs, config = _given(home, graph, folder, origin)
            found = replay_seed(inputs, origin.garment, config, folder)
        else:
            inputs, _ = _given(home, graph, folder, origin, CELL)
            found = replay_commands(inputs, folder)
    except (BadInput, StoreError) as error:
        stop(home.relative(str(error)))
    print(found.said())
    if not found.same:
        raise typer.Exit(1)


@dataclass(frozen=True, kw_only=True)
class _Origin:
    """What simulated an episode."""

    stage: str
    variant: str | None
    garment: str
    settings: dict[str, Any]
    versions: dict[str, str]  # input -> data version


def _given(
    home, graph, folder: Path, origin: _Origin, names: tuple[str, ...] | None = None
) -> tuple[dict[str, dict[str, Path]], Any]:
    """Inputs of the stage that simulated the episode (all, or those with these names), and its settings then.

    Raises:
        BadInput: an input is not the one that the episode was made from.
        StoreError: an input is missing or damaged.
    """
    from assets_defs._config import config_of
    from assets_defs._store import verified
    from sim1.stage import BadInput

    node = graph.nodes.get(f"{origin.variant}/{origin.stage}") or graph.nodes[origin.stage]
    inputs = {}
    for name in names or node.needs:
        id_ = node.needs[name]
        path, record = verified(home, graph.nodes[id_], origin.garment)
        if record["data_version"] != origin.versions[name]:
            raise BadInput(
                f"{folder}: was made from version {origin.versions[name]} of {name}, the store has "
                f"{record['data_version']}; check out what made it, or make the episode again"
            )
        inputs[name] = {origin.garment: path}
    return inputs, dataclasses.replace(config_of(node), **origin.settings)


def _origin(folder: Path) -> _Origin:
    """Raises BadInput where the episode is nobody's."""
    from sim1.stage import BadInput

    root = folder.parent.parent
    if (root / "plan.json").is_file():  # of `sim1 generate`
        plan = json.loads((root / "plan.json").read_text())
        return _Origin(
            stage="candidate_trajectories",
            variant=plan["variant"],
            garment=plan["garment"],
            settings=_below(plan, "setting."),
            versions=_below(plan, "input."),
        )
    try:
        record = json.loads((root / "artifact.json").read_text())
    except OSError:
        raise BadInput(
            f"{folder}: is no episode of an artifact (there is no artifact.json or plan.json two folders up); "
            "give data/store/STAGE/GARMENT/episodes/NNNN"
        ) from None
    if record["stage"] not in STAGES:
        raise BadInput(
            f"{folder}: {record['stage']} keeps a copy; give the episode of candidate_trajectories of the same name"
        )
    parts = record["parts"]
    return _Origin(
        stage=record["stage"],
        variant=record["variant"],
        garment=record["garment"],
        settings=parts["config"],
        versions={name.split(":")[0]: version for name, version in parts["made_from"].items()},
    )


def _below(plan: dict[str, Any], prefix: str) -> dict[str, Any]:
    return {name.removeprefix(prefix): value for name, value in plan.items() if name.startswith(prefix)}
