"""A verdict from fitted models and from what motion that nobody fitted says of them."""

from dataclasses import dataclass

from sim1.mismatch.borne_out import (
    borne_out,
    doubtful,
    heard_of,
    hopeful,
    in_doubt,
    parts_of,
    with_doubtful,
    with_hopeful,
)
from sim1.mismatch.by_others import ByOthers, asked_of_others
from sim1.mismatch.decide import Decision, decide
from sim1.mismatch.engine import Engine
from sim1.mismatch.models import Model
from sim1.mismatch.thresholds import Thresholds
from sim1.mismatch.unfitted import Heard, hear


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """A decision, and what motion held out has to do with it."""

    decision: Decision
    by_fits: Decision  # what fits alone say
    heard: Heard
    hopeful: tuple[Model, ...]  # where fits name nothing: those that were asked, with what was heard added; else none
    by_others: ByOthers | None = None  # what was asked where motion held out said too little for a name

    @property
    def named(self) -> Model:
        """What fits alone have it for; the baseline where they name nothing."""
        return self.by_fits.chosen

    @property
    def asked(self) -> tuple[str, ...]:
        """Effects that motion held out was asked about, and that it could have taken back or spoken for."""
        return tuple(sorted({name for terms in self.heard.residuals for name in terms}))

    @property
    def spoken_for(self) -> tuple[str, ...]:
        """Names that fits left in doubt and motion held out decided for."""
        return tuple(name for name in self.decision.chosen.terms if name not in self.named.terms)

    @property
    def withdrawn(self) -> tuple[str, ...]:
        """Names that motion held out took back."""
        return tuple(name for name in self.named.terms if name not in self.decision.chosen.terms)

    @property
    def against(self) -> float | None:
        """Nats by which motion held out is less likely with what was named, or withdrawn, 0 if nothing was; None: not known."""
        terms = (self.decision.chosen if self.decision.chosen.terms else self.named).terms
        return None if terms in self.heard.unasked else self.heard.against.get(terms, 0.0)


def judge(
    engine: Engine,
    pool: list[Model],
    heldout: tuple[str, ...],
    thresholds: Thresholds,
    measured: frozenset[str],
    *,
    stopped: bool,
) -> Judgement:
    """The verdict on a pool, the recordings `heldout` heard; a search that was `stopped` asks about what it names alone."""
    decision = decide(pool, thresholds, measured)
    null, named = decision.null, decision.chosen
    if not named.terms:
        asked = [] if stopped else hopeful(decision, pool, thresholds, measured)
        heard = hear(engine, null, asked, heldout)
        said = with_hopeful(decision, pool, heard, thresholds, measured)
        return Judgement(decision=said, by_fits=decision, heard=heard, hopeful=tuple(heard_of(pool, heard)))
    more = None if stopped else doubtful(decision, pool, thresholds)
    others = [] if stopped else [*parts_of(pool, more or named), *([more] if more else [])]
    if others:  # where one of them leads in the end and leaves too much, a delay that was measured does
        others += [one for one in pool if one.terms and set(one.terms) <= measured]
    asked = list({one.terms: one for one in (named, *others)}.values())
    heard = hear(engine, null, asked, heldout)
    said = with_doubtful(decision, more, pool, heard.against, thresholds, measured)
    by_others, doubted = None, in_doubt(said, pool, heard.against, thresholds, measured)
    if doubted is not None and not stopped:
        by_others = asked_of_others(engine, null, doubted, heard, heldout, thresholds)
    others = frozenset([by_others.terms] if by_others is not None and by_others.speaks else [])
    said = borne_out(said, pool, heard.against, thresholds, measured, others)
    return Judgement(decision=said, by_fits=decision, heard=heard, hopeful=(), by_others=by_others)
