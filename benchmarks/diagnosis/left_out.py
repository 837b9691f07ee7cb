"""What the diagnosis says of a bundle with one part of it left out.

| column | what is left out |
| --- | --- |
| whole | nothing |
| nothing measured | errors of mesh and step, and wobble: residuals are set against the markers' noise alone |
| not orthogonal | projection: what the model can imitate stays in the fingerprints that shortlists are drawn up by |
| screening alone | simulation of the candidates: the shortlist beside the calibrated baseline has the word |
| fit error alone | price, thresholds and motion held out: the model with the least misfit on what was fitted has the word |
| no veto | motion held out: what fits say is believed, however it is foretold; prices and thresholds stay |
"""

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from sim1.cloth.precise.simulate import NotConverged
from sim1.cloth.precise.world import World
from sim1.mismatch.decide import decide, leaves_more
from sim1.mismatch.diagnose import Diagnosis, as_far_as_tried, diagnose
from sim1.mismatch.engine import Engine, Looked
from sim1.mismatch.excess import mean_square
from sim1.mismatch.fit import Fit, fit, temper_of
from sim1.mismatch.models import judged
from sim1.mismatch.screen import Candidate, screen, site_of
from sim1.mismatch.search import Unknowns
from sim1.mismatch.thresholds import THRESHOLDS
from sim1.recording.bundle import Bundle

COLUMNS = ("whole", "nothing measured", "not orthogonal", "screening alone", "fit error alone", "no veto")
FALL = 0.05  # of the baseline's misfit, by which the least one must be lower to be believed: it never rises with a coefficient more

type Called = tuple[str, tuple[str, ...]]  # verdict, names
type Said = tuple[str, tuple[str, ...], float]  # and seconds by the clock


class Unmeasured(Engine):
    """Knows of no error but the markers' noise."""

    def refine(self, world: World, names: tuple[str, ...]) -> None:
        """Nothing."""

    def soften(self, unknowns: Unknowns, z: np.ndarray, names: tuple[str, ...]) -> Looked:
        """Slopes alone."""
        return self.slopes(unknowns, z, names)


class Unprojected(Engine):
    """Draws up shortlists by fingerprints from which nothing is taken out."""

    projects = False


def with_parts_left_out(bundle: Bundle) -> dict[str, Said]:
    """What each column says, and the seconds that it took beside the whole: two of them read on in its pool of models."""
    began = time.monotonic()
    apart = {"nothing measured": lambda: nothing_measured(bundle), "not orthogonal": lambda: not_orthogonal(bundle)}
    try:
        whole = diagnose(bundle)
    except NotConverged:  # the other columns read on in it
        failed: Said = ("failed", (), time.monotonic() - began)
        return dict.fromkeys(COLUMNS, failed) | {label: _timed(one) for label, one in apart.items()}
    took_s = time.monotonic() - began
    ask = apart | {
        "screening alone": lambda: screening_alone(bundle, whole),
        "fit error alone": lambda: fit_error_alone(whole),
        "no veto": lambda: no_veto(whole),
    }
    return {"whole": (*_called(whole), took_s)} | {label: _timed(one) for label, one in ask.items()}


def nothing_measured(bundle: Bundle) -> Called:
    """The whole diagnosis by an engine that takes its mesh and its step for right."""
    return _called(diagnose(bundle, kind=Unmeasured))


def not_orthogonal(bundle: Bundle) -> Called:
    """The whole diagnosis with shortlists that nothing was taken out of: what they send to be simulated, and from where."""
    return _called(diagnose(bundle, kind=Unprojected))


def screening_alone(bundle: Bundle, whole: Diagnosis) -> Called:
    """What the shortlist beside the baseline of `whole` promises, taken for true: one name, or two.

    A promise of a name's worth is a name. A second one is what promises as much, and the share of the first that a second is asked for,
    over what the first leaves. Without any, a baseline that leaves more than noise and mesh explain is `unknown`.
    """
    with Engine(bundle) as engine:
        base = _measured_at(engine, whole.baseline.fit)
        first = _shortlist(engine, base)[0]
        if first.gain < THRESHOLDS.named:
            return "unknown" if leaves_more(judged(base, base.temper), THRESHOLDS) else "none", ()
        second = _shortlist(engine, _with_its_slopes(engine, base, first))[0]
    both = second.gain >= max(THRESHOLDS.named, THRESHOLDS.second_share * first.gain)
    return "named", tuple(sorted(one.term.effect.name for one in ((first, second) if both else (first,))))


def fit_error_alone(whole: Diagnosis) -> Called:
    """The model of the pool with the least misfit; nothing only where that is lower than the baseline's by less than `FALL`."""
    least = min(whole.models, key=lambda model: mean_square(model.fit))
    if mean_square(least.fit) > (1.0 - FALL) * mean_square(whole.baseline.fit):
        return "none", ()
    return "named", least.terms


def no_veto(whole: Diagnosis) -> Called:
    """What the fits alone say by the rules: motion held out takes back no name and speaks for none."""
    decision = decide(list(whole.models), THRESHOLDS, whole.measured)
    return as_far_as_tried(decision.verdict, whole.stopped, whole.lost, THRESHOLDS), decision.chosen.terms


def _called(found: Diagnosis) -> Called:
    return found.verdict, found.chosen.terms


def _timed(ask: Callable[[], Called]) -> Said:
    """What a column says; `failed`, as a campaign counts it, where no simulation finds its way without the part."""
    began = time.monotonic()
    try:
        verdict, names = ask()
    except NotConverged:
        verdict, names = "failed", ()
    return verdict, names, time.monotonic() - began


def _measured_at(engine: Engine, known: Fit) -> Fit:
    """A fit with errors of mesh and step, and temper, measured where it is: it may have been compared where another model was."""
    engine.refine(known.unknowns.world(known.z), known.names)
    looked = engine.soften(known.unknowns, known.z, known.names)
    found = fit(engine, known.unknowns, known.z, known.names, temper=known.temper, most=0, given=looked)
    return replace(found, temper=temper_of(engine, found.residuals, known.names))


def _with_its_slopes(engine: Engine, base: Fit, first: Candidate) -> Fit:
    """The baseline with a candidate in it at nothing: where it is, no marker moves otherwise, and what it would do is imitated by it."""
    unknowns = base.unknowns.with_terms(first.term)
    z = np.concatenate([base.z, np.zeros(unknowns.count - len(base.z))])
    return fit(engine, unknowns, z, base.names, temper=base.temper, most=0)


def _shortlist(engine: Engine, base: Fit) -> list[Candidate]:
    return screen(engine, base, site_of(engine, base.unknowns.world(base.z)), base.names)
