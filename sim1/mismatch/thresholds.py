"""When a difference counts. What chance alone can do is measured on bundles with nothing missing: `thresholds.yaml`."""

from dataclasses import dataclass
from pathlib import Path

from sim1.data_file import read_data_file
from sim1.stage import stage_config

SCHEMA = "sim1.thresholds/7"
FILE = Path(__file__).with_name("thresholds.yaml")


@stage_config
class Null:
    """A bundle in which nothing was missing."""

    seed: int  # of the laboratory
    worth: float  # nats of the best single effect that is steady and established (`decide.worth`); 0 where none is
    misfit: float  # mean squared residual of the baseline, in units of its variance
    misfit_alone: float  # the same of the recording with the largest
    gain: float  # nats that the best established model gains over the baseline, however often it counts an error
    table: bool  # whether cloth could lie on one


@stage_config
class Measured:
    """Contents of `thresholds.yaml`, written by `sim1 prove --calibrate`."""

    named: float  # that an effect must be worth over the baseline, nats
    named_ci95: tuple[float, float]  # of what the level asks for, by resampling the bundles
    misfit: float  # from which something is missing
    misfit_alone: float  # the same of one recording
    gain: float  # of an established model, from which something is missing though no name is worth enough
    level: float  # share of bundles with nothing missing that may exceed any of these
    code_sha256: tuple[str, ...]  # of the code that diagnosed them, a hash for each of its states
    nulls: tuple[Null, ...]


@dataclass(frozen=True, kw_only=True)
class Thresholds:
    """When a difference counts, in nats of evidence."""

    named: float  # that an effect must be worth over the baseline, and another beside the first
    misfit: float  # mean squared residual, in units of its variance, from which something is missing
    misfit_alone: float  # the same of one recording
    gain: float  # of an established model, from which something is missing though nothing is worth a name
    alone: float = 2.0  # times a name's worth that a name is asked for which motion held out does not speak for
    spoken: float = 3.0  # nats by which it does: a likelihood ratio of 20, which chance reaches in one of 20 at most
    # Of what the first gains that another must gain beside it: its formula may be off by a sixth.
    second_share: float = 0.03
    doubtful: float = 0.4  # of what a second is asked for, from which motion held out is asked whether another is there
    margin: float = 8.0  # over the runner-up
    margin_share: float = 0.002  # and in units of its own gain
    per_term: float = 2.0  # that every effect costs: there are two dozen to choose from
    explained: float = 0.5  # of the excess over noise and mesh that a named model must explain where it gains,
    explained_whole: float = 0.3  # or less, where what it leaves would be nothing missing by itself,
    left: float = 1.1  # unless it leaves no larger a mean square; what is no larger is no excess
    significance: float = 0.05  # of the test that a named effect's strength is not nothing; Student's quantile is long where recordings are few
    steady: float = 4.0  # times that a named effect's evidence may count the same error,
    unsteady: float = 0.3  # unless it differs by no larger a share of itself from second to second
    nulls: int = 0  # bundles with nothing missing that the first four rest on


def read_thresholds(path: Path) -> Thresholds:
    """A name, an excess and a gain ask for what the file has measured; raises BadInput."""
    measured = read_data_file(path, Measured, SCHEMA)
    return Thresholds(
        named=measured.named,
        misfit=measured.misfit,
        misfit_alone=measured.misfit_alone,
        gain=measured.gain,
        nulls=len(measured.nulls),
    )


THRESHOLDS = read_thresholds(FILE)
