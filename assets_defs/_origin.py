"""What simulated an episode, and those inputs again as they were then."""

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

STAGES = ("seed_demos", "real_demos", "candidate_trajectories")  # whose episodes are simulated; later ones are copies


@dataclass(frozen=True, kw_only=True)
class Origin:
    """What simulated an episode."""

    stage: str
    variant: str | None
    garment: str
    settings: dict[str, Any]
    versions: dict[str, str]  # input -> data version


def inputs_then(
    home, graph, folder: Path, origin: Origin, names: tuple[str, ...] | None = None
) -> tuple[dict[str, dict[str, Path]], Any]:
    """Inputs of the stage that simulated the episode (all, or those with these names), and its settings then.

    Raises:
        BadInput: an input is not the one that the episode was made from.
        StoreError: an input is missing or damaged.
    """
    from assets_defs._config import config_of
    from assets_defs._store import verified
    from sim1.stage import BadInput

    node = node_of(graph, origin.stage, origin.variant)
    inputs = {}
    for name in names or node.needs:
        path, record = verified(home, graph.nodes[node.needs[name]], origin.garment)
        if record["data_version"] != origin.versions[name]:
            raise BadInput(
                f"{folder}: was made from version {origin.versions[name]} of {name}, the store has "
                f"{record['data_version']}; check out what made it, or make the episode again"
            )
        inputs[name] = {origin.garment: path}
    return inputs, dataclasses.replace(config_of(node), **origin.settings)


def node_of(graph, stage: str, variant: str | None):
    """Node of a stage in a variant, or in the base where the variant has none of its own."""
    return graph.nodes.get(f"{variant}/{stage}") or graph.nodes[stage]


def origin_of(folder: Path) -> Origin:
    """Raises BadInput where the episode is nobody's."""
    from sim1.stage import BadInput

    root = folder.parent.parent
    if (root / "plan.json").is_file():
        return generated_origin(root)
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
    return Origin(
        stage=record["stage"],
        variant=record["variant"],
        garment=record["garment"],
        settings=record["parts"]["config"],
        versions=made_from(record),
    )


def generated_origin(root: Path) -> Origin:
    """Of all episodes of a folder of `sim1 generate`.

    Raises:
        BadInput: it is none.
    """
    from sim1.stage import BadInput

    try:
        plan = json.loads((root / "plan.json").read_text())
    except (OSError, ValueError) as error:
        raise BadInput(f"{root}/plan.json: not readable ({error}); give a folder of `sim1 generate`") from error
    return Origin(
        stage="candidate_trajectories",
        variant=plan["variant"],
        garment=plan["garment"],
        settings=_below(plan, "setting."),
        versions=_below(plan, "input."),
    )


def made_from(record: dict[str, Any]) -> dict[str, str]:
    """Input -> data version, of an artifact's record."""
    return {name.split(":")[0]: version for name, version in record["parts"]["made_from"].items()}


def _below(plan: dict[str, Any], prefix: str) -> dict[str, Any]:
    return {name.removeprefix(prefix): value for name, value in plan.items() if name.startswith(prefix)}
