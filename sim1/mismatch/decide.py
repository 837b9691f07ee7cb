"""From fitted models to a verdict: what a difference is worth, and which models it lets stand."""

from dataclasses import dataclass

from sim1.cloth.effects import EFFECTS
from sim1.mismatch.excess import explained, left, mean_square, worst
from sim1.mismatch.fit import cost_of
from sim1.mismatch.models import Model
from sim1.mismatch.thresholds import THRESHOLDS, Thresholds
from sim1.mismatch.uncertainty import established, established_along, overcounted, unsteadiness


@dataclass(frozen=True, kw_only=True)
class Decision:
    """A verdict on models that were fitted to the same recordings."""

    verdict: str  # none, named, ambiguous, unknown
    null: Model
    chosen: Model
    rivals: tuple[Model, ...]  # that explain it about as well
    misfit: dict[str, float]  # mean squared residual of baseline and chosen


def rating(model: Model, thresholds: Thresholds = THRESHOLDS) -> float:
    """Score with the price of its coefficients; smaller is better."""
    return model.score + thresholds.per_term * len(model.terms)


def best_of(pool: list[Model], thresholds: Thresholds) -> Model:
    """The model with the best rating."""
    return min(pool, key=lambda model: rating(model, thresholds))


def null_of(pool: list[Model]) -> Model:
    """The baseline among the models."""
    return next(model for model in pool if not model.terms)


def gain_of(pool: list[Model], model: Model, thresholds: Thresholds) -> float:
    """What a model gains over the baseline, nats."""
    return rating(null_of(pool), thresholds) - rating(model, thresholds)


def worth(pool: list[Model], model: Model, thresholds: Thresholds) -> float:
    """What a model gains over the baseline where evidence that counts the same error again and again counts it once, nats."""
    return worth_over(null_of(pool), model, thresholds)


def worth_over(base: Model, model: Model, thresholds: Thresholds, against: float = 0.0) -> float:
    """What a model gains over another, nats; `against`: by how much motion held out speaks for the other.

    Only likelihood is counted too often. What an effect costs, and what it gains as the fabric need not leave its priors, is not.
    """
    rest, likelihood = _by_priors_and_likelihood(base, model, thresholds)
    counted = likelihood - against
    return rest + (counted / overcounted(model.fit, base.fit) if counted > 0.0 else counted)


def _by_priors_and_likelihood(base: Model, model: Model, thresholds: Thresholds) -> tuple[float, float]:
    """What a model gains over another as coefficients need not leave their priors, less what it costs; and by likelihood, nats."""
    gain = rating(base, thresholds) - rating(model, thresholds)
    costs = [cost_of(fit.residuals, fit.names, fit.temper) for fit in (base.fit, model.fit)]
    return gain - (costs[0] - costs[1]), costs[0] - costs[1]


def adds_enough(
    null: Model, less: Model, more: Model, thresholds: Thresholds, *, said: float = 0.0, share: float = 1.0
) -> bool:
    """Whether a model adds to another what one effect more is asked for, or a `share` of it; `said`: nats of motion held out against it.

    A strong effect whose formula is a little off leaves a part of what it gains to whatever imitates the difference. How large a part is a
    matter of what fits gain: motion held out that speaks for the addition is added to that; what it says against is subtracted from what
    the addition is worth, as it may be that the rest of the model, fitted again beside it, foretells another motion worse.
    """
    gain = rating(less, thresholds) - rating(more, thresholds) - min(said, 0.0)
    first = rating(null, thresholds) - rating(less, thresholds)
    worthy = worth_over(less, more, thresholds, said) >= share * thresholds.named
    return worthy and gain >= share * thresholds.second_share * first


def leaves_more(model: Model, thresholds: Thresholds) -> bool:
    """Whether a model leaves more than noise and mesh explain, in all or in one recording: what pushes in one swing is missing too."""
    return mean_square(model.fit) >= thresholds.misfit or worst(model.fit) >= thresholds.misfit_alone


def stands_out(pool: list[Model], thresholds: Thresholds) -> bool:
    """Whether some model gains more than any does where nothing is missing, however often it counts one error.

    What pushes otherwise than any effect of the table makes several of them gain, each now more, now less of itself. A model of which
    recordings do not agree that it is there has fitted one of them: what the simulator gets wrong there, as a rule.
    """
    gains = [gain_of(pool, model, thresholds) for model in pool if model.terms and there(pool, model, thresholds)]
    return max(gains, default=0.0) >= thresholds.gain


def missing(pool: list[Model], thresholds: Thresholds) -> bool:
    """Whether something is missing, whatever it is."""
    return leaves_more(null_of(pool), thresholds) or stands_out(pool, thresholds)


def decide(pool: list[Model], thresholds: Thresholds, measured: frozenset[str] = frozenset()) -> Decision:
    """What a pool of models, the baseline among them, says.

    Effects that the recordings show without any model of the cloth, `measured`, need not explain what is missing: that they
    are there is known, however much else is.
    """
    null = null_of(pool)
    nameless = "unknown" if missing(pool, thresholds) else "none"
    worthy = worthy_of(pool, thresholds)
    if not _leader(pool, worthy, thresholds):
        return unchanged(nameless, null)
    standing = [model for model in worthy if steady(pool, model, thresholds, measured)]
    best = _leader(pool, standing, thresholds)
    if best is None:  # something gains, and nothing that is there beyond doubt
        return unchanged(nameless, null)
    return said_of(null, best, contenders_of(pool, best, thresholds, measured), thresholds, measured)


def worthy_of(pool: list[Model], thresholds: Thresholds) -> list[Model]:
    """The models that are worth a name."""
    return [model for model in pool if model.terms and worth(pool, model, thresholds) >= thresholds.named]


def contenders_of(pool: list[Model], best: Model, thresholds: Thresholds, measured: frozenset[str]) -> list[Model]:
    """Models that stand against a leader: steady and worth a name, or fitting better than it.

    What fits better and is no name, as its evidence counts errors often, is no less likely for that.
    """
    null, lead = null_of(pool), rating(best, thresholds)
    return [
        one
        for one in pool
        if one.terms
        and (
            rating(one, thresholds) < lead
            or (worth_over(null, one, thresholds) >= thresholds.named and steady(pool, one, thresholds, measured))
        )
    ]


def said_of(
    null: Model, best: Model, standing: list[Model], thresholds: Thresholds, measured: frozenset[str]
) -> Decision:
    """The verdict where `best` leads, those that are `standing` against it given: whether it explains what is missing, and who does about as well."""
    asked = thresholds.explained if leaves_more(best, thresholds) else thresholds.explained_whole
    if left(null.fit, best.fit) > thresholds.left and explained(null.fit, best.fit, thresholds) < asked:
        standing = [model for model in standing if set(model.terms) <= measured]
        if not standing:
            return unchanged("unknown", null)
        best = best_of(standing, thresholds)
    rivals = rivals_of([null, *standing], best, thresholds)
    return Decision(
        verdict="ambiguous" if rivals else "named",
        null=null,
        chosen=best,
        rivals=rivals,
        misfit={"baseline": mean_square(null.fit), "chosen": mean_square(best.fit)},
    )


def rivals_of(pool: list[Model], best: Model, thresholds: Thresholds) -> tuple[Model, ...]:
    """Models of other effects, no more of them, that explain it about as well as `best`, or what tells for it."""
    gain = gain_of(pool, told_by(pool, best, thresholds), thresholds)
    close = max(thresholds.margin, thresholds.margin_share * gain)
    return tuple(
        model
        for model in pool
        if model.terms
        and model is not best
        and not set(best.terms) <= set(model.terms)
        and not _contained(best.terms, model.terms)
        and len(model.terms) <= len(best.terms)
        and gain - gain_of(pool, model, thresholds) < close
    )


def there(pool: list[Model], model: Model, thresholds: Thresholds) -> bool:
    """Whether each of a model's effects differs from nothing by recordings that disagree, or by priors alone.

    Asked along the way from the model without it, where the pool has that one; else of its coefficients, by their slopes.
    """
    others = {one.terms: one for one in pool}
    level = thresholds.significance
    for place, term in enumerate(model.fit.unknowns.terms):
        less = others.get(tuple(name for name in model.terms if name != term.effect.name))
        if less is None:
            shown = established(model.fit, place, level)
        else:
            shown = told_by_priors(less, model, thresholds) or established_along(model.fit, less.fit, level)
        if not shown:
            return False
    return True


def told_by_priors(base: Model, model: Model, thresholds: Thresholds) -> bool:
    """Whether what a model adds is a name's worth because the other has to leave its priors to imitate it.

    A baseline whose lengths are off by more than any ruler is moves as cloth that has shrunk: what residuals then differ by says nothing,
    neither whether the effect is there nor whether it is the same from second to second.
    """
    return _by_priors_and_likelihood(base, model, thresholds)[0] >= thresholds.named


def steady(pool: list[Model], model: Model, thresholds: Thresholds, measured: frozenset[str]) -> bool:
    """Whether recordings agree that a model's effects are there, and from second to second on how strong they are.

    What imitates something else is asked for now more, now less than the fit has of it: by nearly all of itself. A right effect whose
    formula is a little off counts that error often where it is strong, and differs by little. Beside a delay that was measured much else
    may be missing.
    """
    null = null_of(pool)
    from_second_to_second = (
        set(model.terms) <= measured
        or told_by_priors(null, model, thresholds)
        or overcounted(model.fit, null.fit) <= thresholds.steady
        or unsteadiness(model.fit, null.fit) <= thresholds.unsteady
    )
    return from_second_to_second and there(pool, model, thresholds)


def unchanged(verdict: str, null: Model) -> Decision:
    """The baseline stays what is simulated: nothing is missing, or nothing that is known explains it."""
    misfit = mean_square(null.fit)
    return Decision(verdict=verdict, null=null, chosen=null, rivals=(), misfit={"baseline": misfit, "chosen": misfit})


def _leader(pool: list[Model], standing: list[Model], thresholds: Thresholds) -> Model | None:
    """The best of those that stand, or a simpler one within its reach; None where none is left.

    Two that gain a little each are no name, however much together: where what is simpler is a part that does not stand, they are left
    aside, and the next best is asked. Simpler is what has some of its effects, the best of all that have fewer, or what is of a family
    that the best one's contains.
    """
    asked = list(standing)
    while asked:
        first = best = best_of(asked, thresholds)
        while (simpler := _simpler(pool, standing, best, thresholds)) is not None:
            best = simpler
        if _among(best, standing):
            return best
        asked = [model for model in asked if model is not first]
    return None


def _simpler(pool: list[Model], standing: list[Model], best: Model, thresholds: Thresholds) -> Model | None:
    """The best simpler model to which `best`, or what tells for it, adds too little."""
    fewer = [model for model in standing if len(model.terms) < len(best.terms)]
    less = [model for model in pool if model.terms and set(model.terms) < set(best.terms)]
    less += [model for model in fewer if _contained(model.terms, best.terms)]
    less += [best_of(fewer, thresholds)] if fewer else []
    narrower = [model for model in standing if _in_place_of(model.terms, best.terms)]
    null, telling = null_of(pool), told_by(standing, best, thresholds)
    within = [model for model in less if not adds_enough(null, model, telling, thresholds)]
    within += [model for model in narrower if not adds_enough(null, model, best, thresholds)]
    return best_of(within, thresholds) if within else None


def told_by(standing: list[Model], model: Model, thresholds: Thresholds) -> Model:
    """The model itself or, if it fits better, one with wider effects in place of its own: what either adds to the rest, that one tells.

    That a stream is no more than still air's drag is a matter between the two; that there is one of them is shown by the better.
    """
    wider = [one for one in standing if _in_place_of(model.terms, one.terms)]
    return best_of([model, *wider], thresholds)


def _among(model: Model, models: list[Model]) -> bool:
    return any(model is one for one in models)


def _contained(small: tuple[str, ...], large: tuple[str, ...]) -> bool:
    """Whether one model is the other with less: wind brings drag with it."""
    inside = {EFFECTS[name].widens for name in large}
    return small != large and set(small) <= set(large) | inside


def _in_place_of(narrow: tuple[str, ...], wide: tuple[str, ...]) -> bool:
    """Whether one model has as many effects as the other, some of them in place of wider ones."""
    return len(narrow) == len(wide) and _contained(narrow, wide)
