"""What a recording that no fit has seen says of models: evidence, taken as that of the fitted ones is.

Markers are drawn softly to the measured ones, as in fits, and so each second is a witness of its own. From rest and drives alone a
sheet goes astray once and stays so: a model that is right may then be off by more than one that is not.
"""

from dataclasses import dataclass, replace

import numpy as np

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import Tempers, cost_of, temper_of
from sim1.mismatch.models import Model

type Nats = dict[tuple[str, ...], float]  # by effects
type Residuals = dict[str, np.ndarray]  # (K,) by recording


@dataclass(frozen=True, kw_only=True)
class Heard:
    """Residuals of recordings that no fit has seen, and what fits would know of them."""

    residuals: dict[tuple[str, ...], Residuals]  # by effects, () the baseline's
    unasked: dict[tuple[str, ...], str]  # models that no simulation follows, and why
    temper: Tempers
    mesh_off: Residuals
    stretch: Residuals

    @property
    def against(self) -> Nats:
        """By how many nats the recordings are less likely with a model than with the baseline; below 0: more likely."""
        costs = {terms: cost_of(one, tuple(self.temper), self.temper) for terms, one in self.residuals.items()}
        return {terms: cost - costs[()] for terms, cost in costs.items() if terms}

    def added_to(self, model: Model) -> Model:
        """The model as if these recordings had been fitted, too, and had taught nothing: the same coefficients, and slopes of 0.

        Raises:
            KeyError: a model that was not asked.
        """
        fit, more = model.fit, self.residuals[model.terms]
        flat = {name: np.zeros((len(residual), len(fit.z))) for name, residual in more.items()}
        whole = replace(
            fit,
            names=(*fit.names, *more),
            temper=fit.temper | self.temper,
            residuals=fit.residuals | more,
            slopes=fit.slopes | flat,
            mesh_off=fit.mesh_off | self.mesh_off,
            stretch=fit.stretch | self.stretch,
        )
        return replace(model, fit=whole)


NOTHING = Heard(residuals={}, unasked={}, temper={}, mesh_off={}, stretch={})


def left_by(engine: Engine, model: Model, heard: Heard, names: tuple[str, ...]) -> Residuals:
    """Residuals (K,) that a model leaves in recordings that no fit has seen: as they were `heard`, or looked at now.

    Raises:
        NotConverged: no simulation of it follows.
    """
    if model.terms in heard.residuals:
        return heard.residuals[model.terms]
    unknowns, z = model.fit.unknowns, model.fit.z
    with engine.aside():
        engine.refine(unknowns.world(z), names)
        return engine.soften(unknowns, z, names)[0]


def hear(engine: Engine, null: Model, models: list[Model], names: tuple[str, ...]) -> Heard:
    """What recordings that no fit has seen say of models, the baseline `null` beside them.

    What mesh and step get wrong, and what hangs on the baseline's coefficients, is measured where the first of the models is, as it is
    where the best one is while models are fitted. Where no simulation follows with the baseline or with the first, none is asked.
    """
    if not models:
        return NOTHING
    with engine.aside():
        try:
            first = models[0].fit
            engine.refine(first.unknowns.world(first.z), names)
            engine.soften(first.unknowns, first.z, names)
            found = {(): engine.residuals(null.fit.unknowns, null.fit.z, names)}
        except NotConverged as error:
            return replace(NOTHING, unasked={model.terms: str(error) for model in models if model.terms})
        unasked = {}
        for model in (one for one in models if one.terms):
            try:
                found[model.terms] = engine.residuals(model.fit.unknowns, model.fit.z, names)
            except NotConverged as error:
                unasked[model.terms] = str(error)
        return Heard(
            residuals=found,
            unasked=unasked,
            temper=temper_of(engine, found[()], names),
            mesh_off=engine.mesh_off(names),
            stretch=engine.stretches(names),
        )
