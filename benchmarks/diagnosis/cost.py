"""What a diagnosis costs, and how much of it is simulating."""

import os
import time
from pathlib import Path

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.diagnose import diagnose
from sim1.recording.bundle import read_bundle


def cost(bundles: list[Path]) -> str:
    """A Markdown table: seconds by the clock of each diagnosis on all cores, the report's pictures not included."""
    lines = [
        f"{len(os.sched_getaffinity(0))} cores",
        "",
        "| bundle | vertices | recordings | recorded [s] | verdict | diagnosis [s] | simulating [s] | the rest [s] |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for folder in bundles:
        bundle = read_bundle(folder)
        recorded_s = sum(float(one.time_s[-1] - one.time_s[0]) for one in bundle.recordings)
        began = time.monotonic()
        try:
            found = diagnose(bundle)
        except NotConverged:
            lines.append(
                f"| {folder.name} | {len(bundle.mesh.vertices_m)} | {len(bundle.recordings)} | {recorded_s:.0f} | no simulation of the baseline | {time.monotonic() - began:.0f} | | |"
            )
            continue
        taken_s = time.monotonic() - began
        named = " + ".join(found.chosen.terms)
        lines.append(
            f"| {folder.name} | {len(bundle.mesh.vertices_m)} | {len(bundle.recordings)} | {recorded_s:.0f} | {found.verdict} {named} | "
            f"{taken_s:.0f} | {found.simulating_s:.0f} | {taken_s - found.simulating_s:.0f} |"
        )
    return "\n".join(lines)
