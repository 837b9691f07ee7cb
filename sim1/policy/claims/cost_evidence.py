"""What prices and measured seconds say to claims of cost."""

import math
from collections.abc import Callable, Mapping
from typing import Any

from sim1.policy.claims.evidence import Evidence, Finder, nothing_of
from sim1.policy.claims.verdict import Measured, Missing
from sim1.statistics import Interval, wilson_interval


def reckoned_per_day(method: int) -> Finder:
    """Dollars a day that follow from the paper's own prices; `method`: place in `costs.json`."""

    def find(known: Evidence) -> Measured | Missing:
        if known.costs is None:
            return nothing_of(known, "cost_report")
        usd = known.costs["methods"][method]["usd_per_day"]
        return Measured(
            shown=f"${usd:.2f}, reckoned",
            interval=Interval(usd, usd),
            remark="arithmetic from the paper's own prices, nothing was measured",
        )

    return find


def unit_cost(known: Evidence) -> Measured | Missing:
    """Dollars a generated trajectory on this machine; the interval is that of the share of attempts that is accepted."""
    return _machine(known, lambda way, scale: (way["usd_per_trajectory"] * scale, "${:.2g}"), rises=True)


def throughput(known: Evidence) -> Measured | Missing:
    """Generated trajectories a day on this machine, likewise."""
    return _machine(known, lambda way, scale: (way["trajectories_per_day"] / scale, "{:.0f}"), rises=False)


def _machine(
    known: Evidence, figure: Callable[[Mapping[str, Any], float], tuple[float, str]], *, rises: bool
) -> Measured | Missing:
    """`figure` at so many times the seconds of a trajectory; `rises` with these."""
    if known.costs is None:
        return nothing_of(known, "cost_report")
    way = next((one for one in known.costs["methods"] if one["measured"]), None)
    pace = known.costs["pace"]
    if way is None or pace is None:
        return Missing(why="this machine's seconds were not measured")
    attempted, accepted = (known.costs[f"{name}_count"] for name in ("attempted", "accepted"))
    each_s = pace["accepted_s"] + pace["shown_s"]
    ends = wilson_interval(accepted, attempted)
    slow, fast = ((pace["attempted_s"] / share + pace["shown_s"]) / each_s for share in ends)
    (value, form), *others = (figure(way, scale) for scale in (1.0, slow, fast))
    low, high = sorted(one for one, _ in others)
    shown = (
        f"{form.format(value)} ({form.format(low)} to {form.format(high)}), {accepted} of {attempted} attempts accepted"
    )
    remark = "of time the interval holds that of the pass rate alone; the price an hour is an assumption"
    if not known.full_frames:  # smaller pictures are cheaper: what the same work costs is more than this
        low, high = (low, math.inf) if rises else (0.0, high)
        bound = "least" if rises else "most"
        remark += f"; frames are smaller or fewer than those of profile paper: with these it would be at {bound} that"
    return Measured(shown=shown, interval=Interval(low, high), remark=remark)
