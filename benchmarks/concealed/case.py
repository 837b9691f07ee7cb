"""One case: which effects, how strong, which motions. Everything follows from the effects, the strength and the seed."""

import zlib
from dataclasses import dataclass

import numpy as np

from benchmarks.concealed.effects.library import LIBRARY
from benchmarks.concealed.motions import FREE_MOTIONS, HANG, MOTIONS, TABLE_MOTIONS, Motion
from benchmarks.concealed.setting import Setting, draw_setting

STRENGTHS = {"weak": 0.3, "medium": 3.5, "strong": 10.0}
"""Change of the markers over the noise, both root mean square, in the motions that show the effect best.

Weak is meant to be below what a diagnosis can detect: from a fifth of medium on, in the median of a campaign, it says that an effect shows."""

FILMED = 5
HELD_OUT = 2
DRAWS = 200
TABLE_SHARE = 0.5
"""Of bundles, those with a table among what is filmed beside the effect: which motions there are tells nothing of what is concealed."""
SHOWN = 3
"""Of those filmed, motions that show the effect, at least."""


@dataclass(frozen=True)
class Plan:
    """One motion to film."""

    name: str
    motion: Motion
    shown: bool
    """Whether it excites the effect."""
    held_out: bool


@dataclass(frozen=True)
class Case:
    """A bundle to make."""

    effects: tuple[str, ...]
    strength: str
    seed: int
    motions: tuple[str, ...] = ()
    """To film, in place of those that are drawn."""
    specimen: int = 0
    """Which cloth, with its motions, of those that follow from the rest."""

    def __post_init__(self) -> None:
        """Refuse what there is not."""
        for name in self.effects:
            if name not in LIBRARY:
                raise ValueError(f"no effect {name!r}: choose from {', '.join(LIBRARY)}")
        if self.strength not in STRENGTHS:
            raise ValueError(f"no strength {self.strength!r}: choose from {', '.join(STRENGTHS)}")
        for name in self.motions:
            if name not in MOTIONS:
                raise ValueError(f"no motion {name!r}: choose from {', '.join(MOTIONS)}")

    @property
    def folder(self) -> str:
        """Name of its folder: medium, the usual strength, goes without saying."""
        strength = "" if self.strength == "medium" or not self.effects else f"_{self.strength}"
        return f"{'+'.join(self.effects) or 'none'}{strength}_{self.seed}"

    def stream(self, purpose: str) -> np.random.Generator:
        """Random numbers for one purpose; a change in one leaves the others as they are."""
        key = f"{'+'.join(self.effects)}|{purpose}" + (f"|{self.specimen}" if self.specimen else "")
        return np.random.default_rng([self.seed, zlib.crc32(key.encode())])

    def setting(self) -> Setting:
        """The truth, effects aside."""
        return draw_setting(self.stream("setting"))


def plans(case: Case, setting: Setting) -> list[Plan]:
    """FILMED motions, at least three of which show the effect, and HELD_OUT others, the first of which does; or those that were chosen.

    Others are of other names, not filmed ones with other amplitudes, and of grips and contacts that filmed ones have.
    """
    rng = case.stream("motions")
    shown_by = _shown_by(case.effects)
    chosen, held_out = (list(case.motions), []) if case.motions else _drawn(case, shown_by, setting, rng)
    out = []
    for number, name in enumerate([*chosen, *held_out]):
        motion = MOTIONS[name](setting.cloth, setting.columns, setting.rows, rng)
        placed = motion.placed(setting.yaw_rad + rng.normal(0, 0.05), setting.shift_m)
        out.append(Plan(f"{name}_{'abcdefghijklmnop'[number]}", placed, name in shown_by, number >= len(chosen)))
    return out


def _drawn(case: Case, shown_by: list[str], setting: Setting, rng: np.random.Generator) -> tuple[list[str], list[str]]:
    """Motions to film, in their order, and to hold out; drawn again until what is filmed leaves two that it says enough of.

    Whether a table is among what is filmed beside the effect is drawn once, not again: what is easily found would come more often.
    """
    table = bool(rng.random() < TABLE_SHARE)
    shown_by = shown_by or _shown_by((_likeness(table, rng),))
    for _ in range(DRAWS):
        shown = [str(name) for name in rng.permutation(shown_by)]
        chosen = _spread(case, shown)
        chosen += _fillers(chosen, table, rng)[: FILMED - len(chosen)]
        foretold = _foretellable(chosen, setting)
        others = [str(name) for name in rng.permutation(list(MOTIONS))]
        known = [name for name in others if name not in (*chosen, HANG) and name in foretold]
        first = next((name for name in shown if name in known), None)
        others = [name for name in known if name != first]
        if first and others:
            return [str(name) for name in rng.permutation(chosen)], [first, others[0]]
    raise ValueError(
        f"{case.folder}: {DRAWS} draws of {FILMED} motions left no {HELD_OUT} others with their grips and their table, one of which "
        f"shows an effect: add to the motions that do (benchmarks/concealed/effects/library.py): {', '.join(shown_by)}"
    )


def _shown_by(effects: tuple[str, ...]) -> list[str]:
    """Motions that show any of the effects, in the order of MOTIONS."""
    return sorted({name for effect in effects for name in LIBRARY[effect].shown_by}, key=list(MOTIONS).index)


def _likeness(table: bool, rng: np.random.Generator) -> str:
    """The effect as which nothing is filmed: one that needs a table only where there is one anyway, so that half have one."""
    return str(rng.choice([name for name in LIBRARY if table or not set(LIBRARY[name].shown_by) & set(TABLE_MOTIONS)]))


def _fillers(chosen: list[str], table: bool, rng: np.random.Generator) -> list[str]:
    """Motions to film beside `chosen`, by rank: one over a table and then any, or free ones alone. What is concealed has no say."""
    order = [str(name) for name in rng.permutation(list(MOTIONS)) if name not in chosen]
    if not table:
        return [name for name in order if name in FREE_MOTIONS]
    first = next(name for name in order if name in TABLE_MOTIONS)
    return [first, *(name for name in order if name != first)]


def _foretellable(filmed: list[str], setting: Setting) -> set[str]:
    """Motions of whose table, if they have one, and of all of whose grips there are films: nothing else tells how those hold the cloth."""
    bare = {
        name: make(setting.cloth, setting.columns, setting.rows, np.random.default_rng(0))
        for name, make in MOTIONS.items()
    }
    grips = {block for name in filmed for block in bare[name].blocks}
    table = any(bare[name].table for name in filmed)
    return {name for name, motion in bare.items() if set(motion.blocks) <= grips and (table or not motion.table)}


def _spread(case: Case, shown: list[str]) -> list[str]:
    """The motions that show the effects: three, and for several effects two of each at least."""
    if len(case.effects) < 2:
        return shown[:SHOWN]
    chosen: list[str] = []
    for effect in case.effects:
        own = [name for name in shown if name in LIBRARY[effect].shown_by]
        have = [name for name in own if name in chosen]
        chosen += [name for name in own if name not in chosen][: max(0, 2 - len(have))]
    return chosen[:FILMED]
