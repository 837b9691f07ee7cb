"""Whether recordings foretell each other by a name: what a model gains most by is left out, and foretold by what the others teach."""

from dataclasses import dataclass, replace

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.borne_out import spoken_for
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import Tempers, cost_of, fit
from sim1.mismatch.models import Model, judged
from sim1.mismatch.thresholds import Thresholds
from sim1.mismatch.unfitted import Heard, hear

STEPS = 4  # of each fit, which sets out from what all recordings taught


@dataclass(frozen=True, kw_only=True)
class ByOthers:
    """A recording that was left out of what taught a model, and what it says of it then."""

    terms: tuple[str, ...]
    recording: str
    # Nats by which it is less likely with the model than with the baseline; None: it could not be asked.
    against: float | None
    speaks: bool  # for the model, by more than chance has it
    unasked: str = ""  # why it could not be asked


def asked_of_others(
    engine: Engine, null: Model, model: Model, heard: Heard, heldout: tuple[str, ...], thresholds: Thresholds
) -> ByOthers:
    """Fit baseline and model without the recording that the model gains most in, and foretell that one with both.

    What was held out teaches in its place, as it has been asked; what mesh and step get wrong in it is measured where the model is, as in
    the others. Where one recording alone is wrongly simulated, others do not foretell what a name gains in it; an effect that acts in
    several they do.
    """
    last = _gains_most(null, model)
    names = tuple(name for name in (*model.fit.names, *heldout) if name != last)
    temper = model.fit.temper | heard.temper
    unasked = ByOthers(terms=model.terms, recording=last, against=None, speaks=False)
    if lost := sorted(set(heldout) - set(temper)):
        return replace(unasked, unasked=f"no simulation follows {', '.join(lost)}, which was to teach in its place")
    try:
        with engine.aside():
            engine.refine(model.fit.unknowns.world(model.fit.z), heldout)
            engine.soften(model.fit.unknowns, model.fit.z, heldout)
            taught = [_taught(engine, one, names, temper) for one in (null, model)]
            said = hear(engine, taught[0], taught[1:], (last,))
    except NotConverged as error:
        return replace(unasked, unasked=str(error))
    if engine.patience.over:
        return replace(unasked, unasked="time was over")
    if model.terms in said.unasked:
        return replace(unasked, unasked=said.unasked[model.terms])
    against = said.against[model.terms]
    return replace(unasked, against=against, speaks=spoken_for(taught[0], taught[1], against, thresholds))


def _gains_most(null: Model, model: Model) -> str:
    """The recording in which a model gains most over the baseline."""
    temper = model.fit.temper
    return max(
        model.fit.names,
        key=lambda name: cost_of(null.fit.residuals, (name,), temper) - cost_of(model.fit.residuals, (name,), temper),
    )


def _taught(engine: Engine, model: Model, names: tuple[str, ...], temper: Tempers) -> Model:
    """A model by other recordings."""
    again = fit(engine, model.fit.unknowns, model.fit.z, names, temper=temper, most=STEPS)
    return judged(again, temper, model.variants)
