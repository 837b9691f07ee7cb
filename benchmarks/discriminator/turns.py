"""Who learns from what, and what each filter says of clips that had no say in it: the video's network, the rules, both."""

from collections.abc import Sequence, Set
from dataclasses import dataclass

import numpy as np
import pandas as pd

from sim1.motion.likeness.classifier import area_under_roc
from sim1.motion.likeness.families import families
from sim1.stage import BadInput, random_stream
from sim1.validity.evidence import threshold_for
from sim1.validity.learning import learned
from sim1.validity.parts import LabelledClip, deal
from sim1.validity.rules import admissible
from sim1.validity.stage import StateRulesConfig, VideoDiscriminatorConfig

RECALL = 0.8  # of the calibration clips, by which the second threshold is chosen
COLUMNS = (
    "name",
    "success",
    "family",
    "precise",
    "generous",
    "rules",
)  # of `Tested`, one entry a clip; `rules` may be None


@dataclass(frozen=True, kw_only=True)
class Turn:
    """One network: what it learns from, what sets its thresholds, what tests it."""

    name: str
    train: list[LabelledClip]
    calibration: list[LabelledClip]
    test: list[LabelledClip]


@dataclass(frozen=True, kw_only=True)
class Tested:
    """Clips that had no say in network, thresholds and rules."""

    name: np.ndarray  # (n,) of the clips
    success: np.ndarray  # (n,) bool
    family: np.ndarray  # (n,) names: clips of one family hang together
    precise: np.ndarray  # (n,) bool, accepted at the threshold of the wanted precision
    generous: np.ndarray  # (n,) bool, accepted at the threshold that keeps `RECALL` of the calibration's successes
    rules: np.ndarray | None  # (n,) bool, admitted by the rules; None where rules do not carry over
    roc_area: tuple[float, ...]  # of each network


def turns_by_fold(garment: str, clips: Sequence[LabelledClip], count: int) -> tuple[list[Turn], int]:
    """Every fold tests once; the second part is how many clips mix demonstrations of several folds and are in none."""
    dealt, left_out = deal(clips, dict.fromkeys(range(count), 1 / count))
    turns = []
    for fold, test in dealt.items():
        judge = (fold + 1) % count
        train = [clip for other, some in dealt.items() if other not in (fold, judge) for clip in some]
        turns.append(Turn(name=f"{garment}, fold {fold}", train=train, calibration=dealt[judge], test=test))
    return turns, len(left_out)


def turn_by_garment(garment: str, clips: dict[str, list[LabelledClip]]) -> Turn:
    """The garment tests what was learned from the others; a fifth of their demonstrations sets the thresholds."""
    others = [clip for name, some in clips.items() if name != garment for clip in some]
    dealt, _ = deal(others, {"train": 0.8, "calibration": 0.2})
    return Turn(name=f"{garment} from the others", **dealt, test=clips[garment])


def run_turn(
    turn: Turn,
    config: VideoDiscriminatorConfig,
    features: pd.DataFrame | None = None,
    out_of_view: Set[str] = frozenset(),
) -> Tested:
    """Train, choose both thresholds, test. `features` (by name of clip) of all clips: rules are learned from what does not test.

    `out_of_view` names clips whose garment left the picture, from which no rules are learned.

    Raises:
        BadInput: clips that train, set thresholds or test are all of one outcome.
    """
    import torch

    from sim1.validity.scoring import scores, train_discriminator

    for part in ("train", "calibration", "test"):
        some = _successes(getattr(turn, part))
        if some.all() or not some.any():
            raise BadInput(
                f"{turn.name}: {some.sum()} of {len(some)} clips of the part {part} are successes, expected some of both; "
                "give fewer folds or more attempts"
            )
    torch.set_num_threads(1)
    network, _ = train_discriminator(turn.train, config, random_stream(config.seed, turn.name))
    score, success = scores(network, [clip.frames for clip in turn.calibration]), _successes(turn.calibration)
    precise = threshold_for(score, success, config.precision)
    generous = np.quantile(score[success], 1 - RECALL, method="lower")
    tested, good = scores(network, [clip.frames for clip in turn.test]), _successes(turn.test)
    kin = families([clip.sources for clip in turn.test])
    return Tested(
        name=np.array([clip.name for clip in turn.test]),
        success=good,
        family=np.array([f"{turn.name}/{number}" for number in kin]),
        precise=np.zeros(len(good), bool) if precise is None else tested >= precise,
        generous=tested >= generous,
        rules=None if features is None else admitted(turn, features, StateRulesConfig(), out_of_view),
        roc_area=(area_under_roc(good, tested),),
    )


def admitted(
    turn: Turn, features: pd.DataFrame, config: StateRulesConfig, out_of_view: Set[str] = frozenset()
) -> np.ndarray:
    """(n,) bool: which test clips the rules admit that are learned from all other clips of the turn but these.

    Features do not say where a garment lay: what is out of view would be folded garments called failures, as in stage state_rules.
    """
    known = [clip for clip in (*turn.train, *turn.calibration) if clip.name not in out_of_view]
    rules = learned(features.loc[[clip.name for clip in known]], _successes(known), config)
    return admissible(rules, features.loc[[clip.name for clip in turn.test]])


def _successes(clips: Sequence[LabelledClip]) -> np.ndarray:
    return np.array([clip.success for clip in clips], bool)


def pooled(tested: Sequence[Tested]) -> Tested:
    """All together; networks differ, so that their scores are not put together but what each accepted is."""

    def column(name: str) -> np.ndarray | None:
        parts = [getattr(one, name) for one in tested]
        return None if any(part is None for part in parts) else np.concatenate(parts)

    columns = {name: column(name) for name in COLUMNS}
    return Tested(**columns, roc_area=tuple(area for one in tested for area in one.roc_area))


def among(tested: Tested, names: Set[str]) -> Tested:
    """The same of these clips alone; areas under curves of whole folds are none of theirs."""
    chosen = np.isin(tested.name, list(names))
    columns = {name: getattr(tested, name) for name in COLUMNS}
    return Tested(**{name: part if part is None else part[chosen] for name, part in columns.items()}, roc_area=())
