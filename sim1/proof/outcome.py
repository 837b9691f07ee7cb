"""What became of one case: `outcomes/CASE.json`, and what follows from its figures."""

import math
from typing import TYPE_CHECKING, Literal

import pydantic

from sim1.mismatch.strict_json import Strict
from sim1.proof.files import Baselines

if TYPE_CHECKING:
    from sim1.recording.bundle import Bundle

REACHED = 0.7  # of the strength that was asked for: with less an effect was out of the laboratory's reach; it stops searching within a factor of 1.4
WORTH = 0.05  # of the baseline's held-out error: where an oracle gains less, there was nothing to recover


class Number(Strict):
    """A coefficient and its 95 % interval; `true` is None where nothing of that name was concealed."""

    value: float
    low: float
    high: float
    unit: str
    true: float | None

    @property
    def holds(self) -> bool:
        """Whether the interval holds the truth."""
        return self.true is not None and self.low <= self.true <= self.high


class Found(Strict):
    """What a diagnosis that came to an end wrote."""

    first: str | None  # of the ranking's models with one effect, the best
    gains: dict[str, float]  # of the ranked models over the baseline, nats
    worths: dict[str, float]  # of that, where evidence that counts the same error again and again counts it once
    least_misfit: tuple[str, ...]  # effects of the ranked model that fits best, at any price
    effects: dict[str, dict[str, Number]]  # of the verdict
    fabric: dict[str, Number]
    misfit: tuple[float, float]  # baseline, chosen: mean squared residual in units of noise and mesh error
    misfit_alone: float  # of the baseline, in the recording with the largest
    misfit_heldout: float | None = (
        None  # of the chosen model, where no fit was; None: not asked, or scored before this was told
    )
    table: bool  # whether cloth could lie on one
    # Recordings that no fit saw; none: scored before this was told, when `held_out` said which one it is.
    heldout: tuple[str, ...] = ()
    fit_mm: tuple[float | None, float | None]  # rmse before and after what was added, from rest and drives alone
    heldout_mm: tuple[float | None, float | None]  # None: no simulation follows all of it
    spoken_for: tuple[str, ...] | None = (
        None  # names that motion held out decided for; None: scored before this was told
    )
    withdrawn: tuple[str, ...] | None = None  # names that it took back; None: scored before this was told
    established: tuple[str, ...] | None = (
        None  # ranked models of which recordings agree that they are there; None: scored before this was told
    )
    steady: tuple[str, ...] | None = None  # those of them that are also asked for alike from second to second
    # Worths with motion held out added, of models that are steady by it; none where fits named something.
    heard: dict[str, float] = pydantic.Field(default_factory=dict)
    place_auc: float | None  # None: force was concealed nowhere or everywhere
    over_limit: dict[
        str, float
    ]  # concealed effect -> its strength in units of that from which it should show, where it can be told

    def heldout_of(self, bundle: "Bundle") -> str:
        """The recording that no fit saw: other methods are held to the same one."""
        from sim1.mismatch.heldout import held_out

        return self.heldout[0] if self.heldout else held_out(bundle)


class Outcome(Strict):
    """What became of one case."""

    case: str
    kind: Literal["null", "outside", "several", "single"]
    concealed: dict[str, dict[str, float]]  # effect -> its true parameters
    strength: str  # as the laboratory was asked
    reached: dict[str, float] = pydantic.Field(
        default_factory=dict
    )  # concealed effect -> how strong it came out, in units of that; only of those where the laboratory says so
    seed: int
    places_given: bool
    verdict: Literal["none", "named", "ambiguous", "unknown", "failed"]
    named: tuple[str, ...]  # the verdict's effects, by name
    right: bool
    error: str | None  # why the diagnosis failed
    seconds: float
    code_sha256: str
    code_changed: bool
    found: Found | None  # None: failed
    unseen_mm: tuple[float | None, float | None] | None = (
        None  # on motions that no diagnosis was given, before and after; None: not filmed; a None in it: not foretold
    )
    not_foretold: dict[str, str] = pydantic.Field(default_factory=dict)  # model, before or after -> why not
    oracle_mm: float | None = (
        None  # held out, of a model that was told the effects; None: not asked, or it found no way
    )
    oracle_unseen_mm: float | None = None  # the same on motions that no diagnosis was given
    oracle_s: float | None = None  # None: not asked
    oracle_lost: dict[str, str] = pydantic.Field(default_factory=dict)  # as `Oracle.lost`
    baselines: Baselines | None = None  # None: not asked

    @property
    def weak(self) -> bool:
        """Whether it is a single effect below what should be found: no name is the honest answer to it, and counted apart."""
        return self.kind == "single" and self.strength == "weak"

    @property
    def as_asked(self) -> bool:
        """Whether everything concealed came out as strong as was asked for, by a laboratory that says so."""
        return all(self.reached.get(name, 0.0) > REACHED for name in self.concealed)

    @property
    def wrong(self) -> bool:
        """Whether something was said that is not so, or nothing where something should be; of a weak effect silence is no fault."""
        return not self.right and not (self.weak and self.verdict in ("none", "unknown", "ambiguous"))

    @property
    def gap_closed(self) -> float | None:
        """Share of what the oracle gains held out that the diagnosis gained; None where there was next to nothing to gain."""
        return self.gap_closed_by(or_infinite(self.found.heldout_mm[1])) if self.found else None

    @property
    def unseen_gap_closed(self) -> float | None:
        """The same on motions that no diagnosis was given."""
        before, after = self.unseen_mm or (None, None)
        return _share_gained(before, or_infinite(after), self.oracle_unseen_mm)

    @property
    def heldout_lost(self) -> bool:
        """Whether no simulation follows held-out motion with what was added, though one does without: infinitely far off."""
        return self.found is not None and _lost(self.found.heldout_mm)

    @property
    def unseen_lost(self) -> bool:
        """The same of motions that no diagnosis was given."""
        return self.unseen_mm is not None and _lost(self.unseen_mm)

    def gap_closed_by(self, after_mm: float) -> float | None:
        """The same of any other method's error held out; without end where that is infinite."""
        return _share_gained(self.found.heldout_mm[0], after_mm, self.oracle_mm) if self.found else None


def or_infinite(error_mm: float | None) -> float:
    """An error of a model that there is: one with which no simulation finds its way is infinitely far off; left out, harm would count as nothing."""
    return math.inf if error_mm is None else error_mm


def _lost(errors_mm: tuple[float | None, float | None]) -> bool:
    return errors_mm[0] is not None and errors_mm[1] is None


def _share_gained(before: float | None, after: float, oracle: float | None) -> float | None:
    """Of what an oracle gains; None where that is not known or next to nothing."""
    if before is None or oracle is None or before - oracle < WORTH * before:
        return None
    return (before - after) / (before - oracle)


def is_right(kind: str, concealed: tuple[str, ...], verdict: str, named: tuple[str, ...]) -> bool:
    """Whether the verdict is the one that was asked for: all names and no other, or no name where none fits."""
    if kind == "null":
        return verdict == "none"
    if kind == "outside":
        return verdict in ("unknown", "ambiguous")
    return verdict == "named" and sorted(named) == sorted(concealed)
