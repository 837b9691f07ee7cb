"""What a recording that no fit has seen says of models: evidence, taken as that of the fitted ones is.

Markers are drawn softly to the measured ones, as in fits, and so each second is a witness of its own. From rest and drives alone a
sheet goes astray once and stays so: a model that is right may then be off by more than one that is not.
"""

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import cost_of, temper_of
from sim1.mismatch.models import Model

type Nats = dict[tuple[str, ...], float]  # by effects


def nats_against(
    engine: Engine, null: Model, models: list[Model], names: tuple[str, ...]
) -> tuple[Nats, dict[tuple[str, ...], str]]:
    """By how many nats recordings are less likely with a model than with the baseline, by effects; below 0: more likely.

    What mesh and step get wrong, and what hangs on the baseline's coefficients, is measured where the first of the models is, as it is
    where the best one is while models are fitted. The second part is of models that could not be asked, and why: no simulation follows
    with them, with the baseline or with the first.
    """
    if not models:
        return {}, {}
    against, unasked = {}, {}
    with engine.aside():
        try:
            first = models[0].fit
            engine.refine(first.unknowns.world(first.z), names)
            engine.soften(first.unknowns, first.z, names)
            before = engine.residuals(null.fit.unknowns, null.fit.z, names)
        except NotConverged as error:
            return {}, {model.terms: str(error) for model in models}
        temper = temper_of(engine, before, names)
        for model in models:
            try:
                after = engine.residuals(model.fit.unknowns, model.fit.z, names)
            except NotConverged as error:
                unasked[model.terms] = str(error)
            else:
                against[model.terms] = cost_of(after, names, temper) - cost_of(before, names, temper)
    return against, unasked
