"""What motion that nobody fitted says of a decision: it may speak for a first name or one effect more, and takes names back."""

from dataclasses import replace

from sim1.mismatch.decide import (
    Decision,
    adds_enough,
    best_of,
    contenders_of,
    decide,
    gain_of,
    missing,
    rating,
    said_of,
    steady,
    told_by,
    unchanged,
    worth_over,
    worthy_of,
)
from sim1.mismatch.excess import mean_square
from sim1.mismatch.models import Model
from sim1.mismatch.thresholds import Thresholds
from sim1.mismatch.uncertainty import overcounted
from sim1.mismatch.unfitted import Heard

# By effects: nats by which motion held out is less likely with a model than with the baseline; below 0: more likely.
type Against = dict[tuple[str, ...], float]


def hopeful(
    decision: Decision, pool: list[Model], thresholds: Thresholds, measured: frozenset[str] = frozenset()
) -> list[Model]:
    """Where nothing stands: models that gain what a name is asked for, however often they count an error, and their parts, best first.

    Motion held out is asked about them. What stands by fits and explains too little is refused, and asks nobody.
    """
    if decision.chosen.terms or any(steady(pool, one, thresholds, measured) for one in worthy_of(pool, thresholds)):
        return []
    gaining = [one for one in pool if one.terms and gain_of(pool, one, thresholds) >= thresholds.named]
    parts = {part.terms for one in gaining for part in parts_of(pool, one)}
    asked = [one for one in pool if one.terms in parts or any(one is other for other in gaining)]
    return sorted(asked, key=lambda model: rating(model, thresholds))


def heard_of(pool: list[Model], heard: Heard) -> list[Model]:
    """Of a pool's models those that motion held out was asked about, the baseline among them, with it added to what they were fitted to."""
    return [heard.added_to(one) for one in pool if one.terms in heard.residuals]


def with_hopeful(
    decision: Decision,
    pool: list[Model],
    heard: Heard,
    thresholds: Thresholds,
    measured: frozenset[str] = frozenset(),
) -> Decision:
    """What fits and motion held out say together where fits alone name nothing; the decision as it is if that motion speaks for nothing.

    Asked is what fits are asked: how often the evidence counts one error, whether it is there and steady, what it explains; what stands and
    explains too little is `unknown`. What a search made of an error of the simulator foretells no other motion, so that this is the harder
    of the two tests to pass by chance.
    """
    added = heard_of(pool, heard)
    if not any(
        steady(added, one, thresholds, measured) and heard.against[one.terms] < 0.0
        for one in worthy_of(added, thresholds)
    ):
        return decision
    again = decide(added, thresholds, measured)
    if not again.chosen.terms:
        return unchanged("unknown", decision.null)
    fitted = {one.terms: one for one in pool}
    chosen = fitted[again.chosen.terms]
    return replace(
        again,
        null=decision.null,
        chosen=chosen,
        rivals=tuple(fitted[one.terms] for one in again.rivals),
        misfit={"baseline": mean_square(decision.null.fit), "chosen": mean_square(chosen.fit)},
    )


def doubtful(decision: Decision, pool: list[Model], thresholds: Thresholds) -> Model | None:
    """The best model with one effect more than was chosen that adds nearly enough: motion held out is asked whether it does."""
    if not decision.chosen.terms or decision.rivals:
        return None
    chosen = decision.chosen
    more = [one for one in pool if set(chosen.terms) < set(one.terms)]
    null, nearly = decision.null, thresholds.doubtful
    more = [one for one in more if adds_enough(null, chosen, one, thresholds, share=nearly)]
    return best_of(more, thresholds) if more else None


def with_doubtful(
    decision: Decision,
    more: Model | None,
    pool: list[Model],
    against: Against,
    thresholds: Thresholds,
    measured: frozenset[str] = frozenset(),
) -> Decision:
    """The decision for the model with one effect more, if with what motion held out says it adds enough and stands.

    Motion that could not be simulated with one of the two says nothing.
    """
    if more is None or not {more.terms, decision.chosen.terms} <= set(against):
        return decision
    said = against[more.terms] - against[decision.chosen.terms]
    if not adds_enough(decision.null, decision.chosen, more, thresholds, said=said):
        return decision
    if not steady(pool, more, thresholds, frozenset()):
        return decision
    return _said_again(decision.null, more, pool, thresholds, measured)


def borne_out(
    decision: Decision,
    pool: list[Model],
    against: Against,
    thresholds: Thresholds,
    measured: frozenset[str] = frozenset(),
    others: frozenset[tuple[str, ...]] = frozenset(),
) -> Decision:
    """What motion that nobody fitted leaves of a decision.

    An effect beside another stays if what it adds, there too, is worth a second one. A name that this motion does not speak for, nor any
    recording that was left out for it, has to be worth `alone` times as much as one that it does. What is no name's worth is nothing, or
    `unknown` if something is missing; what no longer explains what is missing is `unknown`. `against`: see `Against`, of the chosen model
    and of its parts in the pool; what motion held out was not asked about, as time ran out or no simulation follows, it neither takes away
    nor speaks for. `others`: models for which a recording speaks that was left out.
    """
    null = decision.null
    if not decision.chosen.terms:
        return decision
    best, kept = _left_of(decision, pool, against, thresholds, measured)
    known = best.terms in others or not _untested(null, best, against, thresholds, measured)
    if kept < thresholds.named * (1.0 if known else thresholds.alone) or not steady(pool, best, thresholds, measured):
        return unchanged("unknown" if missing(pool, thresholds) else "none", null)
    return decision if best is decision.chosen else _said_again(null, best, pool, thresholds, measured)


def in_doubt(
    decision: Decision,
    pool: list[Model],
    against: Against,
    thresholds: Thresholds,
    measured: frozenset[str] = frozenset(),
) -> Model | None:
    """The model that `borne_out` would keep if only some motion spoke for it that did not teach it; None: there is no such doubt."""
    if not decision.chosen.terms:
        return None
    best, kept = _left_of(decision, pool, against, thresholds, measured)
    doubted = thresholds.named <= kept < thresholds.alone * thresholds.named
    silent = _untested(decision.null, best, against, thresholds, measured)
    return best if doubted and silent and steady(pool, best, thresholds, measured) else None


def _left_of(
    decision: Decision, pool: list[Model], against: Against, thresholds: Thresholds, measured: frozenset[str]
) -> tuple[Model, float]:
    """Of a named model what motion held out leaves: the model or the best of its parts, and what that is worth less what is said against it."""
    null, best = decision.null, decision.chosen
    asked = [part for part in parts_of(pool, best) if part.terms in against]
    telling = told_by(
        [one for one in worthy_of(pool, thresholds) if steady(pool, one, thresholds, measured)], best, thresholds
    )
    for part in sorted(asked, key=lambda model: rating(model, thresholds)) if best.terms in against else ():
        said = against[best.terms] - against[part.terms]
        if set(part.terms) < set(best.terms) and not adds_enough(null, part, telling, thresholds, said=said):
            best = telling = part
    return best, worth_over(null, best, thresholds, max(against.get(best.terms, 0.0), 0.0))


def _untested(null: Model, model: Model, against: Against, thresholds: Thresholds, measured: frozenset[str]) -> bool:
    """Whether nothing but what taught a model says that it is right."""
    return not set(model.terms) <= measured and not spoken_for(null, model, against.get(model.terms, 0.0), thresholds)


def spoken_for(null: Model, model: Model, against: float, thresholds: Thresholds) -> bool:
    """Whether motion that did not teach a model is likelier with it than with the baseline, by more than chance has it.

    Of an effect that is not there it is likelier by a factor of k in one case of k at most (Markov), whatever fits made of it: they never
    saw that motion. (Of a recording that was left out afterwards the fits know nothing either, but the name was chosen with it in view.)
    An error that is counted often in fits is so here. `against`: nats by which it is less likely.
    """
    return -against >= thresholds.spoken * overcounted(model.fit, null.fit)


def parts_of(pool: list[Model], model: Model) -> list[Model]:
    """Models with some of a model's effects, not all."""
    return [one for one in pool if one.terms and set(one.terms) < set(model.terms)]


def _said_again(
    null: Model, best: Model, pool: list[Model], thresholds: Thresholds, measured: frozenset[str]
) -> Decision:
    """Another model leads: what it leaves unexplained and who rivals it are asked anew."""
    return said_of(null, best, contenders_of(pool, best, thresholds, measured), thresholds, measured)
