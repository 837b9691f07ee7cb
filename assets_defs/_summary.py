"""One page for the whole run: pictures and figures of every stage, and how long each took."""

from pathlib import Path
from typing import Any

from assets_defs._produce import label
from assets_defs._store import place
from pipeline import Graph, Home
from sim1.report import Picture, Section, write_report

PICTURES_AT_MOST = 3  # per artifact


def write_summary(home: Home, graph: Graph) -> Path:
    """Write `data/store/report.html` from the records of all artifacts; returns its path."""
    sections, seconds = [], []
    garments = home.garments()
    for node in graph.nodes.values():
        keys = garments if node.per else [None]
        records = [(key, record) for key in keys if (record := place(home, node, key).record())]
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
            folder = place(home, node, key).final
            for picture in sorted(folder.glob("*.png"))[:PICTURES_AT_MOST]:
                pictures.append(Picture(path=picture, caption=f"{label(node, key)}: {picture.stem.replace('_', ' ')}"))
        sections.append(
            Section(
                heading=node.id.replace("_", " "),
                paragraphs=[node.stage.summary],
                table=[_row(key, record) for key, record in records],
                pictures=pictures,
            )
        )
    sections.append(
        Section(
            heading="seconds per stage",
            paragraphs=["Sum over garments of the time each artifact took when it was last made; two ran at a time."],
            table=seconds,
        )
    )
    home.store.mkdir(parents=True, exist_ok=True)
    page = home.store / "report.html"
    part = page.with_suffix(".part")
    write_report(
        part,
        title="From scan to scaling curve",
        lead=(
            f"Profile {graph.profile}, garments {', '.join(garments)}. Shipped scans are virtual, demonstrations come from a "
            "scripted expert, and simulation plays the part of reality: no figure on this page was measured on a real robot."
        ),
        sections=sections,
    )
    part.rename(page)
    return page


def _row(key: str | None, record: dict[str, Any]) -> dict[str, Any]:
    facts = {
        name: value for name, value in record["facts"].items() if isinstance(value, str | int | float | bool | None)
    }
    return {"garment": key or "all", **facts, "seconds": record["seconds"]}
