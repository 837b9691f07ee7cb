"""The contest, and a second one where it explains what it was given and not the recording that was held out: that one has something to teach."""

from collections.abc import Callable
from dataclasses import dataclass

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.contest import Contest, contest
from sim1.mismatch.decide import leaves_more
from sim1.mismatch.engine import Engine
from sim1.mismatch.excess import mean_square_of
from sim1.mismatch.fit import Fit
from sim1.mismatch.heldout import held_out
from sim1.mismatch.judging import Judgement, judge
from sim1.mismatch.search import baseline
from sim1.mismatch.thresholds import Thresholds
from sim1.mismatch.unfitted import left_by
from sim1.recording.bundle import Bundle

STOPPED = "there was no time for it"
AGAIN = 0.5  # of the way, from which a second round is told to go on

Progress = Callable[[float, str], None]


@dataclass(frozen=True, kw_only=True)
class Round:
    """A contest on some recordings, and the verdict that the rest had a say in."""

    fitted: tuple[str, ...]
    heldout: tuple[str, ...]
    found: Contest
    judged: Judgement
    stopped: bool  # before all was tried
    left: float | None = (
        None  # mean squared residual that the chosen model leaves in what was held out; None: not asked, or no simulation follows
    )
    not_left: str | None = None  # why no simulation follows

    def unexplained(self, thresholds: Thresholds) -> bool:
        """Whether what was held out shows more than any single recording of a bundle with nothing missing does."""
        return self.left is not None and self.left >= thresholds.misfit_alone


@dataclass(frozen=True, kw_only=True)
class Rounds:
    """The round whose verdict stands, and the one before it."""

    last: Round
    taught_by: Round | None = None  # whose recording held out was fitted in the last; None: there was no other
    not_taught: str | None = None  # why another came to no end

    @property
    def stopped(self) -> bool:
        """Before all was tried that should have been."""
        return self.last.stopped or self.not_taught == STOPPED


def rounds(
    engine: Engine,
    bundle: Bundle,
    thresholds: Thresholds,
    measured: frozenset[str],
    progress: Progress,
    calibrated: Callable[[Fit], None],
) -> Rounds:
    """Hold one recording out and find what the others say; where that does not explain it, fit it, hold another out and start afresh.

    There is no third: what is held out second is less like what is fitted, and a round costs as much as everything before it. A second
    that comes to no end changes nothing.

    Raises:
        NotConverged: a recording that the baseline cannot follow, of those that are fitted first.
    """

    def told(start: float) -> Progress:
        return lambda share, what: progress(start + (1.0 - start) * share, what)

    heldout = held_out(bundle)
    first = _round(engine, bundle, heldout, thresholds, measured, told(0.0), calibrated)
    if first.stopped or len(first.fitted) < 2 or not first.unexplained(thresholds):
        return Rounds(last=first)
    if engine.patience.over:
        return Rounds(last=first, not_taught=STOPPED)
    other = held_out(bundle, but=heldout)
    try:
        second = _round(engine, bundle, other, thresholds, measured, told(AGAIN), calibrated)
    except NotConverged as error:
        return Rounds(last=first, not_taught=str(error))
    return Rounds(last=first, not_taught=STOPPED) if second.stopped else Rounds(last=second, taught_by=first)


def _round(
    engine: Engine,
    bundle: Bundle,
    heldout: str,
    thresholds: Thresholds,
    measured: frozenset[str],
    progress: Progress,
    calibrated: Callable[[Fit], None],
) -> Round:
    fitted = tuple(name for name in engine.names if name != heldout)
    found = contest(engine, baseline(bundle), fitted, thresholds, progress, calibrated)
    stopped = engine.patience.over
    progress(1.0, "checking on motion held out")
    judged = judge(engine, found.pool, (heldout,), thresholds, measured, stopped=stopped)
    chosen, left, not_left = judged.decision.chosen, None, None
    if not stopped and not leaves_more(chosen, thresholds):  # else it is no witness: that something is missing is known
        try:
            left = mean_square_of(left_by(engine, chosen, judged.heard, (heldout,)))
        except NotConverged as error:
            not_left = str(error)
    return Round(
        fitted=fitted, heldout=(heldout,), found=found, judged=judged, stopped=stopped, left=left, not_left=not_left
    )
