"""The figures that a run's reports wrote, which claims are held against."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from sim1.policy.claims.verdict import Measured, Missing
from sim1.policy.curve import Curve
from sim1.policy.image_trials.measures import ShiftTried


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """Contents of the reports; None of one that was not made or cannot be read, with the reason in `why`."""

    curve: Curve | None = None
    ablation: Mapping[str, Mapping[str, Any]] | None = None  # variant -> its row of table.json
    image: Sequence[ShiftTried] | None = None
    costs: Mapping[str, Any] | None = None
    why: Mapping[str, str] = field(default_factory=dict)  # stage -> why it says nothing
    full_frames: bool = False  # whether frames are no smaller and no fewer than those of profile paper


type Finder = Callable[[Evidence], Measured | Missing]


def nothing_of(known: Evidence, stage: str) -> Missing:
    """A stage whose report says nothing, and why."""
    return Missing(why=known.why.get(stage, f"stage {stage} was not made"))
