"""When a difference counts, from cases in which nothing was concealed: what the best effect gains and a baseline leaves there by chance."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import yaml
from scipy.stats import CensoredData, gumbel_r, norm, rv_continuous

from sim1.cloth.effects import EFFECTS
from sim1.mismatch.thresholds import SCHEMA, THRESHOLDS, Measured, Null
from sim1.proof.outcome import Found, Outcome
from sim1.stage import BadInput, random_stream
from sim1.whole_file import whole_file

LEVEL = 0.05  # share of bundles with nothing missing that may exceed any of the thresholds, which share it evenly
SHARED_BY = 4  # thresholds: a name's worth, two of misfit, and what any model gains
LEAST = 10  # such bundles; fewer say nothing about one in twenty
ROUND, ROUND_MISFIT = 5.0, 0.05  # upwards; nats, and mean squares
RESAMPLES = 200
LEAST_NAMED = 20.0  # nats: cloth of other laboratories may be harder to simulate than that of the one which calibrates
STRANGE = 0.1  # share of cases that may be of another kind than most


def calibrated(outcomes: Sequence[Outcome]) -> Measured:
    """What the best of all effects that stand is worth and a baseline leaves by chance but for `LEVEL` of the bundles.

    In a share of bundles nothing stands; what stands in others falls off like the tail of the largest of many, exponentially. What the worst
    simulated of some motions leaves is Gumbel distributed, the mean of all is normal. No bundle seen would be given a name; a nearly
    chaotic one may be called unknown.

    Raises:
        BadInput: too few cases with nothing concealed, none with a table or none without, one during which the code changed, or one
            scored by code that did not tell which models are steady.
    """
    nulls = [outcome for outcome in outcomes if outcome.kind == "null" and outcome.found is not None]
    if len(nulls) < LEAST or len({outcome.found.table for outcome in nulls}) < 2:
        raise BadInput(
            f"{len(nulls)} cases with nothing concealed are diagnosed, {LEAST} are needed, with a table and without one; go on with the campaign"
        )
    untold = [outcome.case for outcome in nulls if outcome.found.established is None or outcome.found.steady is None]
    if untold:
        raise BadInput(
            f"outcomes/{untold[0]}.json, of {len(untold)} such: scored before it was told which models are steady; diagnose and score them by this code"
        )
    changed = [outcome.case for outcome in nulls if outcome.code_changed]
    if changed:
        raise BadInput(f"outcomes/{changed[0]}.json: the code changed while it was diagnosed; diagnose it again")
    worths = np.array([_worth(one.found) for one in nulls])
    gains = np.array([max([0.0, *(one.found.gains[name] for name in one.found.established)]) for one in nulls])
    stream = random_stream(0, "calibration")
    again = [tail_of(stream.choice(worths, len(worths))) for _ in range(RESAMPLES)]
    low, high = np.quantile(again, [0.025, 0.975])
    return Measured(
        named=max(LEAST_NAMED, _most(worths)),
        named_ci95=(round(float(low), 1), round(float(high), 1)),
        misfit=_above(level_of(np.array([one.found.misfit[0] for one in nulls]), norm), ROUND_MISFIT),
        misfit_alone=_above(level_of(np.array([one.found.misfit_alone for one in nulls])), ROUND_MISFIT),
        gain=_most(gains),
        level=LEVEL,
        code_sha256=tuple(sorted({outcome.code_sha256 for outcome in nulls})),
        nulls=tuple(
            Null(
                seed=one.seed,
                worth=round(float(worths[k]), 1),
                misfit=round(one.found.misfit[0], 3),
                misfit_alone=round(one.found.misfit_alone, 3),
                gain=round(float(gains[k]), 1),
                table=one.found.table,
            )
            for k, one in enumerate(nulls)
        ),
    )


def _worth(found: Found) -> float:
    """Nats of the best single effect that stands, by fits or by fits and motion held out.

    One that motion held out was asked about and does not speak for is as far from a name as one of half the worth that it does.
    """
    asked = {name: THRESHOLDS.alone if name in (found.withdrawn or ()) else 1.0 for name in found.steady or ()}
    return max(largest({name: found.worths[name] / times for name, times in asked.items()}), largest(found.heard))


def _most(nats: np.ndarray) -> float:
    """What the level asks for, and at least what was seen."""
    return _above(max(tail_of(nats), float(nats.max())), ROUND)


def _above(value: float, step: float) -> float:
    """The next multiple of `step`."""
    return round(float(step * np.ceil(value / step)), 6)


def largest(worths: dict[str, float]) -> float:
    """Of the models with one effect; 0 where none gained anything."""
    return max([0.0, *(worth for name, worth in worths.items() if name in EFFECTS)])


def tail_of(nats: np.ndarray) -> float:
    """What is exceeded in its share of `LEVEL` of the cases: of those above 0, which are some of all, an exponential's quantile; else 0.

    The scale is that of most likelihood; of the largest tenth of them it is taken to be known that they are large, not how large.
    """
    gained = nats[nats > 0]
    if not len(gained):
        return 0.0
    large = float(np.quantile(gained, 1 - STRANGE))
    scale = float(np.minimum(gained, large).sum()) / int((gained <= large).sum())
    return float(scale * np.log(max(len(gained) / len(nats) / (LEVEL / SHARED_BY), 1.0)))


def level_of(squares: np.ndarray, family: rv_continuous = gumbel_r) -> float:
    """What is exceeded in its share of `LEVEL` of the cases, by a distribution of most likelihood.

    Of the largest tenth it is taken to be known that they are large, not how large: one chaotic sheet else decides.
    """
    large = np.quantile(squares, 1 - STRANGE)
    seen, most = squares[squares <= large], squares[squares > large]
    place, spread = family.fit(CensoredData(uncensored=seen, right=np.full(len(most), large)))
    return float(family.ppf(1 - LEVEL / SHARED_BY, place, spread))


def write_thresholds(path: Path, measured: Measured) -> None:
    """Write the file that `sim1.mismatch.thresholds` reads."""
    fields = asdict(measured)
    fields |= {name: list(fields[name]) for name in ("nulls", "named_ci95", "code_sha256")}
    with whole_file(path) as part:
        part.write_text(yaml.safe_dump({"schema": SCHEMA, **fields}, sort_keys=False))
