"""What fits leave over noise and mesh, and how much of it a model explains."""

import numpy as np

from sim1.mismatch.fit import Fit, cost_of
from sim1.mismatch.thresholds import Thresholds

MEDIAN = 0.455  # of squared normal numbers
GROSS = 25.0  # squared residuals count no more than this: a marker that was mislabelled is not physics


def mean_square(fit: Fit, names: tuple[str, ...] = (), gross: float = GROSS) -> float:
    """Mean squared residual of some recordings, or all, gross errors capped, in units of its variance."""
    return mean_square_of({name: fit.residuals[name] for name in names or fit.names}, gross)


def mean_square_of(residuals: dict[str, np.ndarray], gross: float = GROSS) -> float:
    """The same of residuals (K,) by recording."""
    values = np.concatenate(list(residuals.values()))
    return float(np.mean(np.minimum(values**2, gross)))


def worst(fit: Fit) -> float:
    """Mean squared residual of the recording with the largest."""
    return mean_square(fit, (worst_recording(fit),))


def worst_recording(fit: Fit) -> str:
    """The recording with the largest mean squared residual."""
    return max(fit.names, key=lambda name: mean_square(fit, (name,)))


def on_table(fit: Fit) -> bool:
    """Whether cloth could lie on a table."""
    return fit.unknowns.base.table_z_m is not None


def _gross(null: Fit, name: str) -> float:
    """What counts as a gross error in a recording that the baseline misses by far: it is set by how far that is.

    Else nearly all of its residuals are capped, and nothing that a model explains shows.
    """
    return GROSS * max(1.0, float(np.median(null.residuals[name] ** 2)) / MEDIAN)


def explained(null: Fit, model: Fit, thresholds: Thresholds) -> float:
    """Share of the excess over noise and mesh that a model explains: by recording, weighed by what it gains in each, or of all, if that is more.

    What is wrong where it does nothing, wrinkles say, is no witness against it; fitting better what had no excess, none for it. What it
    gains because the baseline had to leave its priors to imitate it is explained.
    """
    return max(_where_it_gains(null, model, thresholds), _of_all(null, model))


def _of_all(null: Fit, model: Fit) -> float:
    """Share of what all recordings together leave above 1; 0 where none leaves anything."""
    before, after = (
        sum(max(mean_square(fit, (name,), _gross(null, name)) - 1.0, 0.0) for name in null.names)
        for fit in (null, model)
    )
    return 1.0 - after / before if before > 0.0 else 0.0


def _where_it_gains(null: Fit, model: Fit, thresholds: Thresholds) -> float:
    gains, shares = _gains(null, model), []
    for name in model.names:
        gross = _gross(null, name)
        before, after = mean_square(null, (name,), gross), mean_square(model, (name,), gross)
        shares.append(np.clip((before - after) / (before - 1.0), 0.0, 1.0) if before > thresholds.left else 0.0)
    plausible = max(0.5 * float(null.z @ null.z - model.z @ model.z), 0.0)
    return float((np.dot(gains, shares) + plausible) / max(gains.sum() + plausible, 1e-9))


def left(null: Fit, model: Fit) -> float:
    """Mean squared residual that a model leaves, by recording, weighed by what it gains in each."""
    gains = _gains(null, model)
    if not gains.any():
        return mean_square(model)
    return float(np.dot(gains, [mean_square(model, (name,)) for name in model.names]) / gains.sum())


def _gains(null: Fit, model: Fit) -> np.ndarray:
    """Nats of likelihood by recording; 0 where a model loses."""
    costs = [[cost_of(fit.residuals, (name,), fit.temper) for name in model.names] for fit in (null, model)]
    return np.maximum(np.subtract(*costs), 0.0)
