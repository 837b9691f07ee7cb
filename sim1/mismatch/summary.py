"""`summary.json`, schema `sim1.diagnosis/15`: what the page for a person says beyond the verdict, without the arrays it comes from."""

from pathlib import Path
from typing import Literal

import pydantic

from sim1.mismatch.strict_json import Strict, read_json

SCHEMA = "sim1.diagnosis/15"


class Ranked(Strict):
    """A model that was fitted."""

    name: str
    gain: float  # over the calibrated baseline, nats
    worth: float  # of that, where evidence that counts the same error again and again counts it once
    unsteadiness: float  # by what share of itself it differs from second to second
    established: bool  # whether, by recordings that disagree or by priors alone, its effects' strengths are not nothing
    steady: bool  # whether that is so and it is asked for alike, from second to second, or told by priors alone: else it is no name
    misfit: float  # mean squared residual in units of noise and mesh error
    # Worth and `steady` with motion held out added to what was fitted; None: it was not asked for a first name.
    heard_worth: float | None = None
    heard_steady: bool | None = None


class Estimate(Strict):
    """A coefficient of the chosen model, in its own unit."""

    name: str
    unit: str
    prior: float
    value: float
    low: float  # of the 95 % interval
    high: float


class Misfit(Strict):
    """Mean squared residual on the fitted recordings, in units of noise and mesh error; 1 is all that can be asked."""

    baseline: float
    chosen: float
    limit: float  # from which something is taken to be missing
    alone: float  # of the baseline, in the recording with the largest
    heldout: (
        float | None
    )  # of the chosen model, where no fit was; None: not asked, as it leaves too much where one was, or no simulation follows
    table: bool  # whether cloth could lie on one


class Shown(Strict):
    """From which strength on an effect would show (`detectable.py`)."""

    effect: str
    coefficient: str
    unit: str
    absent: float
    least: float | None  # None: at no strength that can be foretold


class Undecided(Strict):
    """What a diagnosis leaves open."""

    what: str
    record: str  # that would settle it


class OfState(Strict):
    """A state of the sheet, and whether the force that was located depends on it (`state.py`)."""

    name: str
    share: pydantic.confloat(ge=0, le=1)  # of the force's square above noise, beyond the other states
    depends: Literal["yes", "no", "undecided"]


class Prices(Strict):
    """What a name has to gain in nats, to explain and to foretell."""

    per_term: float
    named: float  # what an effect has to be worth, and one more beside it,
    alone: float  # times that where motion held out does not speak for it,
    spoken: float  # which it does by so many nats, an error that is counted often by as much more
    margin: float
    second_share: float  # of what the first gains, that one more has to gain
    explained: float  # share of the excess misfit where it gains, unless it leaves at most `left`,
    explained_whole: float  # or where it leaves less than makes something missing
    left: float
    significance: float  # of the test that an effect's strength is not nothing
    misfit_alone: float  # mean squared residual of one recording from which something is taken to be missing
    steady: float  # times that a named effect's evidence may count the same error of the simulator,
    unsteady: float  # unless it differs by no larger a share of itself from second to second
    gain: float  # of an established model, from which something is taken to be missing
    nulls: int  # bundles with nothing missing that `named` rests on


class Summary(Strict):
    """Contents of `summary.json`."""

    schema_: Literal["sim1.diagnosis/15"] = pydantic.Field(default=SCHEMA, alias="schema")
    sentence: str
    fitted: tuple[str, ...]  # recordings
    heldout: tuple[str, ...]  # seen by no fit; what it says against a name counts
    heldout_nats: float | None  # by which it is less likely with what was named than with the baseline; None: not known
    spoken_for: tuple[str, ...]  # names that fits left in doubt and that it decided for
    withdrawn: tuple[str, ...]  # names of which it left too little, or that are worth too little without it
    converged: bool  # the searches of the baseline and of the chosen model
    creep_m: float  # of markers over the cloth, standard deviation by coordinate; counted as an error that lasts
    misfit: Misfit
    prices: Prices
    ranking: tuple[Ranked, ...]
    estimates: tuple[Estimate, ...]
    effects: tuple[str, ...]  # of the chosen model
    detectable: tuple[Shown, ...]
    undecided: tuple[Undecided, ...]  # what the verdict leaves open, then what recordings like these cannot tell
    states: tuple[OfState, ...]  # empty where no force could be located


def read_summary(path: Path) -> Summary:
    """Read and check `summary.json`.

    Raises:
        BadInput: missing, or not the schema.
    """
    return read_json(path, Summary, "make calibrated_physics again")
