"""One case: which effects, how strong, which motions. Everything follows from the effects, the strength and the seed."""

import zlib
from dataclasses import dataclass

import numpy as np

from benchmarks.concealed.effects.library import LIBRARY
from benchmarks.concealed.motions import FREE_MOTIONS, MOTIONS, TABLE_MOTIONS, Motion
from benchmarks.concealed.setting import Setting, draw_setting

STRENGTHS = {"weak": 1.0, "medium": 3.5, "strong": 10.0}
"""Change of the markers over the noise, both root mean square, in the motions that show the effect best."""

FILMED = 5
HELD_OUT = 2


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
        key = f"{'+'.join(self.effects)}|{purpose}"
        return np.random.default_rng([self.seed, zlib.crc32(key.encode())])

    def setting(self) -> Setting:
        """The truth, effects aside."""
        return draw_setting(self.stream("setting"))


def plans(case: Case, setting: Setting) -> list[Plan]:
    """FILMED motions, at least three of which show the effect, and HELD_OUT others, the first of which does; or those that were chosen."""
    rng = case.stream("motions")
    shown_by = sorted({name for effect in case.effects for name in LIBRARY[effect].shown_by}, key=list(MOTIONS).index)
    chosen, held_out = (list(case.motions), []) if case.motions else _drawn(case, shown_by, rng)
    out = []
    for number, name in enumerate([*chosen, *held_out]):
        motion = MOTIONS[name](setting.cloth, setting.columns, setting.rows, rng)
        placed = motion.placed(setting.yaw_rad + rng.normal(0, 0.05), setting.shift_m)
        out.append(Plan(f"{name}_{'abcdefghijklmnop'[number]}", placed, name in shown_by, number >= len(chosen)))
    return out


def _drawn(case: Case, shown_by: list[str], rng: np.random.Generator) -> tuple[list[str], list[str]]:
    """Motions to film, in their order, and to hold out."""
    table = [name for name in shown_by if name in TABLE_MOTIONS]
    if table:
        pool = [*TABLE_MOTIONS, *rng.choice(FREE_MOTIONS, 3, replace=False)]
    elif case.effects and all(LIBRARY[effect].loose for effect in case.effects) and rng.random() < 0.4:
        pool = [*FREE_MOTIONS, *rng.choice(TABLE_MOTIONS, 2, replace=False)]
    elif not case.effects and rng.random() < 0.5:
        pool = [*rng.choice(FREE_MOTIONS, 5, replace=False), *TABLE_MOTIONS]
    else:
        pool = list(FREE_MOTIONS)
    shown = [str(name) for name in rng.permutation(shown_by or pool)]
    chosen = _spread(case, shown, rng)
    rest = [str(name) for name in rng.permutation([name for name in pool if name not in chosen])]
    chosen += rest[: FILMED - len(chosen)]
    held_out = [next((name for name in shown if name not in chosen), shown[0])]
    held_out.append(next(name for name in rest if name not in chosen and name not in held_out))
    return [str(name) for name in rng.permutation(chosen)], held_out


def _spread(case: Case, shown: list[str], rng: np.random.Generator) -> list[str]:
    """The motions that show the effects: three, and for several effects two of each at least."""
    if len(case.effects) < 2:
        return shown[: min(3, len(shown))]
    chosen: list[str] = []
    for effect in case.effects:
        own = [name for name in shown if name in LIBRARY[effect].shown_by]
        have = [name for name in own if name in chosen]
        chosen += [name for name in own if name not in chosen][: max(0, 2 - len(have))]
    return chosen[:FILMED]
