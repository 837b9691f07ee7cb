"""Whether recordings foretell each other by a name: what a model gains most by is left out, and foretold by what the others teach."""

from dataclasses import dataclass

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
    against: float  # nats by which it is less likely with the model than with the baseline
    speaks: bool  # for the model, by more than chance has it


def asked_of_others(
    engine: Engine, null: Model, model: Model, heard: Heard, heldout: tuple[str, ...], thresholds: Thresholds
) -> ByOthers | None:
    """Fit baseline and model without the recording that the model gains most in, and foretell that one with both.

    What was held out teaches in its place: it has been asked. Where one recording alone is wrongly simulated, others do not foretell what
    a name gains in it; an effect that acts in several they do. None where no simulation follows, or time is over.
    """
    last = _gains_most(null, model)
    names = tuple(name for name in (*model.fit.names, *heldout) if name != last)
    temper = model.fit.temper | heard.temper
    try:
        taught = [_taught(engine, one, names, temper) for one in (null, model)]
        said = hear(engine, taught[0], taught[1:], (last,))
    except NotConverged:
        return None
    if engine.patience.over or model.terms in said.unasked:
        return None
    against = said.against[model.terms]
    return ByOthers(
        terms=model.terms,
        recording=last,
        against=against,
        speaks=spoken_for(taught[0], taught[1], against, thresholds),
    )


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
