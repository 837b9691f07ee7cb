"""What trials say to claims of success, of its growth, and of the worth of a real demonstration."""

import math

from sim1.policy import paper
from sim1.policy.claims.evidence import Evidence, Finder, nothing_of
from sim1.policy.claims.verdict import Measured, Missing
from sim1.policy.counting import percentage_points, rate
from sim1.policy.curve import Curve
from sim1.policy.equivalence import Worth
from sim1.policy.image_trials.measures import by_shift, of_all
from sim1.policy.lessons import GENERATED, NAMES
from sim1.policy.shift_table import OURS
from sim1.policy.success_law import SuccessLaw
from sim1.policy.tried import Tried
from sim1.statistics import Interval


def worth_of_a_real_demonstration(shift: str) -> Finder:
    """Generated trajectories that make a policy as good as one real demonstration, by success; `shift` is the paper's name."""
    own = OURS[shift]

    def find(known: Evidence) -> Measured | Missing:
        if known.curve is None:
            return nothing_of(known, "scaling_report")
        found = next((one for one in known.curve.worths if isinstance(one, Worth) and one.shift == own), None)
        if found is None:
            said = [one for one in known.curve.worths if isinstance(one, str) and not one.startswith("action error")]
            own_said = [one for one in said if one.startswith(f"success, {own}:")]
            other_said = [one for one in said if not one.startswith("success, ")]
            if not _was_tried(known.curve, own):
                return Missing(
                    why=f"no policy was tried with {own} changed" if own != "in-domain" else "no trial was run"
                )
            return Measured(shown="not known", interval=None, remark="; ".join(own_said or other_said))
        if found.interval is None:
            return Measured(
                shown=f"{found.bound or ''} {found.ratio:.3g}".strip(), interval=None, remark="one trial: no interval"
            )
        low, high = found.interval
        below, above = found.beyond
        words = f"{'at most ' if below else ''}{low:.2g} to {'at least ' if above else ''}{high:.2g}"
        return Measured(
            shown=f"{f'{found.bound} ' if found.bound else ''}{found.ratio:.3g} ({words}), at {found.real_size} real ones (stand-in)",
            interval=Interval(0.0 if below else low, math.inf if above else high),
        )

    return find


def generated_over_real(shift: str) -> Finder:
    """Success after generated trajectories minus that after real demonstrations."""

    def find(known: Evidence) -> Measured | Missing:
        if known.curve is None:
            return nothing_of(known, "scaling_report")
        found = known.curve.over_real.get(OURS.get(shift, shift))
        if found is None:
            return Missing(
                why="no policies after generated and after real demonstrations were tried so from the same placements"
            )
        return Measured(shown=f"{percentage_points(found)} (points)", interval=found.interval)

    return find


def state_success(shift: str) -> Finder:
    """Success after the largest number of generated trajectories that drove, of the policy that knows the keypoints."""
    own = OURS[shift]

    def find(known: Evidence) -> Measured | Missing:
        if known.curve is None:
            return nothing_of(known, "scaling_report")
        drove = [point for point in known.curve.points if point.trained_on == GENERATED and point.trials]
        tried = [one for one in max(drove, key=lambda point: point.size).trials if one.shift == own] if drove else []
        return _share(tried[0]) if tried else Missing(why=f"no trial {own}")

    return find


def image_success(shift: str) -> Finder:
    """The same of the policy that sees pictures; `paper.AVERAGE`: of all shifts, where all were tried."""

    def find(known: Evidence) -> Measured | Missing:
        if known.image is None:
            return nothing_of(known, "image_trials")
        tried = {one.shift: one for one in by_shift(known.image)}
        if shift == paper.AVERAGE:
            if missing := [name for name in paper.SHIFTS if name not in tried]:
                return Missing(why=f"not all shifts were tried: {', '.join(missing)}")
            return _share(of_all(known.image))
        return _share(tried[shift]) if shift in tried else Missing(why=f"no trial {shift}")

    return find


def success_slope(shift: str) -> Finder:
    """Whether more generated trajectories succeed more often."""

    def find(known: Evidence) -> Measured | Missing:
        if known.curve is None:
            return nothing_of(known, "scaling_report")
        laws = [one for one in known.curve.success_fits if isinstance(one, SuccessLaw)]
        found = next((one for one in laws if (one.trained_on, one.shift) == (GENERATED, shift)), None)
        if found is None:
            whys = [one for one in known.curve.success_fits if isinstance(one, str)]
            own = [one for one in whys if one.startswith(NAMES[GENERATED])]
            return Missing(why="; ".join(own or whys) or f"no trial {shift}")
        interval = found.slope_interval
        ends = f" ({interval.low:.2f} to {interval.high:.2f})" if interval else ", no interval"
        return Measured(
            shown=f"odds of success as n^b, b = {found.slope:.2f}{ends}, {found.size_count} sizes, {found.trial_count} trials",
            interval=interval,
            remark="" if interval else "one trial a size",
        )

    return find


def _share(tried: Tried) -> Measured:
    return Measured(
        shown=f"{rate(tried.success_count, tried.trial_count, tried.interval)} (%)", interval=tried.interval
    )


def _was_tried(curve: Curve, shift: str) -> bool:
    return any(tried.shift == shift for point in curve.points for tried in point.trials)
