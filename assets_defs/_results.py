"""What stands at the end of a run: which results are of this run, which are older and whether they still hold; warnings."""

import time
from collections.abc import Iterable, Iterator

from assets_defs._recipe import Key, Snapshot, Status, label
from assets_defs._store import place
from pipeline import Node

RESULTS = {  # stage -> what a person calls its artifact, and the file or folder to look at
    "dataset": ("dataset", "lerobot"),
    "image_policy": ("image policy", "report.html"),
    "image_trials": ("image policy in the closed loop", "report.html"),
    "scaling_report": ("scaling report", "report.html"),
    "ablation_report": ("ablation report", "report.html"),
    "cost_report": ("cost report", "report.html"),
}


def results(snapshot: Snapshot, made: Iterable[str]) -> Iterator[str]:
    """A line per result that exists. `made`: labels of what this run made; of all else the age and the state are said."""
    home = snapshot.home
    for id_, (title, file) in RESULTS.items():
        if (node := snapshot.graph.nodes.get(id_)) is None:
            continue
        at = place(home, node, None)
        if at.record() is None or not (at.final / file).exists():
            continue
        age = "" if id_ in made else f" (made {_age(time.time() - at.made_at())} ago, {state(snapshot, node, None)})"
        yield f"{title}: {(at.final / file).relative_to(home.root)}{age}"


def state(snapshot: Snapshot, node: Node, key: Key) -> str:
    """State of an artifact in words: is it what its recipe would make now, and if not, why and of which profile it is."""
    if snapshot.status(node, key).state == "fresh":
        return "fresh"
    profile = (place(snapshot.home, node, key).record() or {}).get("profile", snapshot.graph.profile)
    made_in = f"; made in profile {profile}" if profile != snapshot.graph.profile else ""
    name, status = _cause(snapshot, node, key)
    why = "the last try failed" if status.state == "failed" else status.why
    return "stale: " + (f"{name}: " if name != label(node, key) else "") + why + made_in


def _cause(snapshot: Snapshot, node: Node, key: Key) -> tuple[str, Status]:
    """The uppermost artifact that keeps this one from being fresh (the first of several), and its status."""
    for _, parent, parent_key in snapshot.parents(node, key):
        if snapshot.status(parent, parent_key).state != "fresh":
            return _cause(snapshot, parent, parent_key)
    return label(node, key), snapshot.status(node, key)


def warnings(snapshot: Snapshot) -> Iterator[tuple[Node, Key, str]]:
    """An artifact and what its check found that does not keep it out of the store."""
    for node, key in snapshot.artifacts():
        record = place(snapshot.home, node, key).record()
        for finding in record["findings"] if record else ():
            if not finding["passed"]:
                yield node, key, f"{finding['name'].replace('_', ' ')}: {finding['detail']}"


def _age(seconds: float) -> str:
    for unit, length in (("days", 86400), ("h", 3600), ("min", 60)):
        if seconds >= 2 * length or (unit == "min" and seconds >= length):
            return f"{seconds / length:.0f} {unit}"
    return f"{seconds:.0f} s"
