"""When a difference counts, from cases in which nothing was concealed: what the best effect gains and a baseline leaves there by chance."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import yaml
from scipy.stats import CensoredData, gumbel_r

from sim1.mismatch.thresholds import SCHEMA, Measured, Null
from sim1.proof.score import BASELINE, JOINT, Outcome
from sim1.stage import BadInput, random_stream

LEVEL = 0.05  # share of bundles with nothing missing that may exceed any of the thresholds, which share it evenly
THRESHOLDS = 3
LEAST = 10  # such bundles; fewer say nothing about one in twenty
ROUND, ROUND_MISFIT = 5.0, 0.05  # upwards; nats, and mean squares
RESAMPLES = 200


def calibrated(outcomes: Sequence[Outcome]) -> Measured:
    """What the best of all effects is worth and a baseline leaves by chance but for `LEVEL` of the bundles.

    The best of many is Gumbel distributed, and so is what the worst simulated of some motions leaves. Bundles in which no effect promised
    anything are known to lie at 0 or below. No bundle seen would be given a name; a nearly chaotic one may be called unknown.

    Raises:
        BadInput: too few cases with nothing concealed, or diagnosed by different code.
    """
    nulls = [outcome for outcome in outcomes if outcome.kind == "null" and outcome.found is not None]
    if len(nulls) < LEAST:
        raise BadInput(
            f"{len(nulls)} cases with nothing concealed are diagnosed, {LEAST} are needed; go on with the campaign"
        )
    codes = sorted({outcome.code_sha256 for outcome in nulls})
    if len(codes) > 1 or any(outcome.code_changed for outcome in nulls):
        raise BadInput(f"cases were diagnosed by {len(codes)} states of the code; calibrate with a campaign by one")
    worths = np.array([largest(outcome.found.worths) for outcome in nulls])
    stream = random_stream(0, "calibration")
    again = [level_of(stream.choice(worths, len(worths))) for _ in range(RESAMPLES)]
    low, high = np.quantile(again, [0.025, 0.975])
    return Measured(
        named=_above(max(level_of(worths), worths.max()), ROUND),
        named_ci95=(round(float(low), 1), round(float(high), 1)),
        misfit=_above(level_of(np.array([one.found.misfit[0] for one in nulls])), ROUND_MISFIT),
        misfit_alone=_above(level_of(np.array([one.found.misfit_alone for one in nulls])), ROUND_MISFIT),
        level=LEVEL,
        code_sha256=codes[0],
        nulls=tuple(
            Null(
                seed=one.seed,
                worth=round(float(worth), 1),
                misfit=round(one.found.misfit[0], 3),
                misfit_alone=round(one.found.misfit_alone, 3),
            )
            for one, worth in zip(nulls, worths, strict=True)
        ),
    )


def _above(value: float, step: float) -> float:
    """The next multiple of `step`."""
    return round(float(step * np.ceil(value / step)), 6)


def largest(worths: dict[str, float]) -> float:
    """Of the models with one effect; 0 where none gained anything."""
    return max([0.0, *(worth for name, worth in worths.items() if name != BASELINE and JOINT not in name)])


def level_of(gains: np.ndarray) -> float:
    """What is exceeded in a third of `LEVEL` of the cases, by a Gumbel distribution of most likelihood; 0 where nothing ever gained."""
    seen, none = gains[gains > 0], gains[gains <= 0]
    if len(np.unique(seen)) < 2:
        return float(gains.max())
    place, spread = gumbel_r.fit(CensoredData(uncensored=seen, left=none))
    return float(gumbel_r.ppf(1 - LEVEL / THRESHOLDS, place, spread))


def write_thresholds(path: Path, measured: Measured) -> None:
    """Write the file that `sim1.mismatch.thresholds` reads."""
    fields = asdict(measured)
    fields["nulls"], fields["named_ci95"] = [asdict(null) for null in measured.nulls], list(measured.named_ci95)
    part = path.with_name(f"{path.name}.part")
    part.write_text(yaml.safe_dump({"schema": SCHEMA, **fields}, sort_keys=False))
    part.replace(path)
