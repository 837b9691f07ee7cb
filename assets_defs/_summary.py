"""One page for the whole run: what was found, then pictures and figures of every stage, and how long each took."""

from pathlib import Path
from typing import Any

from assets_defs._config import resolved_config
from assets_defs._recipe import Key, Snapshot, label
from assets_defs._results import state, warnings
from assets_defs._store import place
from pipeline import GraphError, Node, load_graph
from pipeline.home import PROFILES
from sim1.report import Picture, Section, write_report
from sim1.whole_file import whole_file

PICTURES_AT_MOST = 3  # per artifact

type _Present = list[tuple[Node, Key, dict[str, Any]]]
"""Artifacts that there are, with their records."""


def write_summary(snapshot: Snapshot) -> Path:
    """Write `data/store/report.html` from the records of all artifacts; returns its path."""
    from sim1.policy.results_page import results  # takes seconds to import, and is needed at the end of a run alone

    home, profile = snapshot.home, snapshot.graph.profile
    present = [(node, key, record) for node, key in snapshot.artifacts() if (record := place(home, node, key).record())]
    states = {label(node, key): state(snapshot, node, key) for node, key, _ in present}
    found = results(_base(snapshot, present), _remarks(present, states), _plans(snapshot))
    shown = {picture.path for section in found for picture in section.pictures}
    made = _made(snapshot, present, states, shown)
    index = f"Below, in the order of the graph: {', '.join(section.heading for section in made)}."
    home.store.mkdir(parents=True, exist_ok=True)
    page = home.store / "report.html"
    with whole_file(page) as part:
        write_report(
            part,
            title="From scan to scaling curve",
            lead=(
                f"{_origin(states, profile)} Garments: {', '.join(snapshot.garments)}. Shipped scans are virtual, demonstrations come from a "
                "scripted expert (from a person for garments with commands in data/demonstrations/), and simulation plays the part of reality: but for those that are called the paper's, no figure on this page was "
                "measured on a real robot."
            ),
            sections=[*found, Section(heading="What every stage made", paragraphs=[index]), *made],
        )
    return page


def _made(snapshot: Snapshot, present: _Present, states: dict[str, str], shown: set[Path]) -> list[Section]:
    """A section per stage, and one of the time they took. `shown`: pictures that stand on the page already."""
    sections, seconds = [], []
    home, profile = snapshot.home, snapshot.graph.profile
    mixed = any(found != "fresh" for found in states.values())
    told: dict[str, list[str]] = {}
    for node, key, said in warnings(snapshot):
        told.setdefault(node.id, []).append(f"Warning{f', {key}' if key else ''}: {said}.")
    for node in snapshot.graph.nodes.values():
        records = [(key, record) for other, key, record in present if other is node]
        if not records:
            continue
        seconds.append(
            {
                "stage": node.id,
                "artifacts": len(records),
                "seconds": round(sum(record["seconds"] for _, record in records), 1),
            }
        )
        if node.variant:
            continue
        pictures = []
        for key, _ in records:
            new = [path for path in sorted(place(home, node, key).final.glob("*.png")) if path not in shown]
            for picture in new[:PICTURES_AT_MOST]:
                pictures.append(Picture(path=picture, caption=f"{label(node, key)}: {picture.stem.replace('_', ' ')}"))
        sections.append(
            Section(
                heading=node.id.replace("_", " "),
                paragraphs=[node.stage.summary, *told.get(node.id, [])],
                table=[
                    _row(key, record, states[label(node, key)] if mixed else None, profile) for key, record in records
                ],
                pictures=pictures,
            )
        )
    last = Section(
        heading="seconds per stage",
        paragraphs=["Sum over garments of the time each artifact took when it was last made; two ran at a time."],
        table=seconds,
    )
    return [*sections, last]


def _base(snapshot: Snapshot, present: _Present) -> dict[str, dict[str, Path]]:
    """Artifacts of the base graph by stage and garment; none of a stage that was not run."""
    made: dict[str, dict[str, Path]] = {node.id: {} for node in snapshot.graph.nodes.values() if not node.variant}
    for node, key, _ in present:
        if not node.variant:
            made[node.id][key or ""] = place(snapshot.home, node, key).final
    return made


def _plans(snapshot: Snapshot) -> Any:
    """Settings in every profile of the nodes that measure what the paper claims; of one that cannot be read, why."""
    from sim1.policy.claims.page import NODES, Plans

    settings: dict[str, dict[str, dict[str, Any]]] = {}
    damaged: dict[str, str] = {}
    for profile in PROFILES:
        try:
            nodes = load_graph(snapshot.home, profile).nodes
        except GraphError as error:
            damaged[profile] = str(error)
        else:
            settings[profile] = {id_: resolved_config(nodes[id_]) for id_ in NODES if id_ in nodes}
    return Plans(profile=snapshot.graph.profile, settings=settings, damaged=damaged)


def _remarks(present: _Present, states: dict[str, str]) -> dict[str, str]:
    """Stage -> which of its artifacts are not what the graph makes now, and why."""
    told: dict[str, list[str]] = {}
    for node, key, _ in present:
        if (state := states[label(node, key)]) != "fresh":
            told.setdefault(node.id, []).append(f"{label(node, key)} is {state}")
    return {stage: "; ".join(said) for stage, said in told.items()}


def _origin(states: dict[str, str], profile: str) -> str:
    fresh = sum(found == "fresh" for found in states.values())
    if fresh == len(states):
        return f"Profile {profile}."
    return (
        f"Mixed: {fresh} of {len(states)} artifacts are what profile {profile} makes now; of the others the column state "
        "says why they are not, and the column profile what they were made in."
    )


def _row(key: str | None, record: dict[str, Any], state: str | None, profile: str) -> dict[str, Any]:
    """`state`: None where all artifacts are fresh and of one profile, so that nothing needs to be said."""
    origin = {}
    if state is not None:
        origin = {"profile": profile if state == "fresh" else record.get("profile"), "state": state}
    facts = {
        name: value for name, value in record["facts"].items() if isinstance(value, str | int | float | bool | None)
    }
    return {"garment": key or "all", **origin, **facts, "seconds": record["seconds"]}
