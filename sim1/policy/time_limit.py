"""How long a trial lasts: success is judged at its end, so trials that are compared must be allowed the same time."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from sim1.policy.lessons import GENERATED, REAL, SIMULATED, Lesson

FIRST = (REAL, SIMULATED, GENERATED)  # every variant is given the same real demonstrations, whatever it learns from


@dataclass(frozen=True, kw_only=True)
class TimeLimit:
    """Of the trials with one garment."""

    duration_s: float
    longest_of: str  # kind of the trajectories whose longest it was taken from


def time_limits(
    lessons: Iterable[Lesson], garments: Sequence[str], factor: float, rate_hz: int
) -> dict[str, TimeLimit]:
    """For each garment, `factor` times its longest real demonstration, also where no policy learns from these.

    A garment without: its longest demonstration in the simulator, then its longest generated trajectory. Variants that make these
    anew may allow it another time.
    """
    frames: dict[tuple[str, str], int] = {}
    for lesson in lessons:
        for item in (*lesson.train, *lesson.held_out):
            key = item.garment, lesson.kind
            frames[key] = max(frames.get(key, 0), len(item.state))
    kinds = {name: next(kind for kind in FIRST if (name, kind) in frames) for name in garments}
    return {
        name: TimeLimit(duration_s=factor * frames[name, kind] / rate_hz, longest_of=kind)
        for name, kind in kinds.items()
    }
