"""How strong an effect is, in the markers: measured, then set to what the strength's name promises."""

from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.concealed.case import STRENGTHS, Case, Plan
from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.effects.library import LIBRARY
from benchmarks.concealed.film import Stage, Track, film
from benchmarks.concealed.imitation import CHECK_TIMES_S, Changes, imitations, own

USUAL = {"weak": 0.3, "medium": 1.0, "strong": 2.5}
"""Amplitude to begin with."""
WITHIN = np.log(1.4)

Films = dict[str, Track]
"""Tracks by the plan's name."""


def moves_m(effects: Sequence[Effect], with_them: Track, without: Track) -> np.ndarray:
    """(F, M, 3) change of the markers' reported places over one recording."""
    return reported(effects, with_them, CHECK_TIMES_S) - reported([], without, CHECK_TIMES_S)


def rms(moves: np.ndarray) -> float:
    """Root mean square over times, markers and coordinates."""
    return float(np.sqrt((moves**2).mean()))


def reported(effects: Sequence[Effect], track: Track, stamps_s: np.ndarray) -> np.ndarray:
    """(F, M, 3) what the cameras report without noise, at stamps (F,)."""
    stamps = np.repeat(stamps_s[:, None], track.places_m.shape[1], axis=1)
    sample = track.sample
    for effect in effects:
        sample = _observed(effect, sample)
    return sample(stamps)


def _observed(effect: Effect, sample: Callable[[np.ndarray], np.ndarray]) -> Callable[[np.ndarray], np.ndarray]:
    return lambda stamps: effect.observe(stamps, sample)


def tuned(
    case: Case, stage: Stage, plan_list: Sequence[Plan], without: Films, tries: int = 6
) -> tuple[list[Effect], Films, list[float]]:
    """The case's effects, each as strong alone as the case asks, measured on the two motions out of three that show it best.

    Measured is what no fabric imitates. Also the tracks that were made with all of them on the way, those of a single effect, and
    how strong each came out, in units of the noise.
    """
    shown = {name: _shown(name, plan_list) for name in case.effects}
    wanted = {plan.name: plan for plans in shown.values() for plan in plans}
    imitated = imitations(stage, list(wanted.values())) if wanted else {}
    found = [_tuned(case, stage, shown[name], without, imitated, name, tries) for name in case.effects]
    films = found[0][1] if len(found) == 1 else {}
    return [effect for effect, _, _ in found], films, [strength for _, _, strength in found]


def _shown(name: str, plan_list: Sequence[Plan]) -> list[Plan]:
    """Three motions that show an effect."""
    filmed = [plan for plan in plan_list if not plan.held_out]
    return ([plan for plan in filmed if plan.motion.name in LIBRARY[name].shown_by] or filmed)[:3]


def _tuned(
    case: Case,
    stage: Stage,
    shown: Sequence[Plan],
    without: Films,
    imitated: dict[str, np.ndarray],
    name: str,
    tries: int,
) -> tuple[Effect, Films, float]:
    recipe, noise = LIBRARY[name], stage.setting.noise_m

    def attempt(amplitude: float) -> tuple[float, tuple[Effect, Films, float]]:
        effect = recipe.draw(amplitude, case.stream(name), stage.setting)
        films = {p.name: without[p.name] if effect.measures_only else film(stage, p, [effect]) for p in shown}
        changes: Changes = {p.name: moves_m([effect], films[p.name], without[p.name]) for p in shown}
        left = sorted(map(rms, own(changes, imitated, noise).values()))[-2:]
        strength = float(np.sqrt(np.mean(np.square(left)))) / noise
        return strength / STRENGTHS[case.strength], (effect, films, strength)

    return nearest_to_one(attempt, USUAL[case.strength], recipe.amplitudes, tries)


def nearest_to_one[T](
    attempt: Callable[[float], tuple[float, T]], usual: float, limits: tuple[float, float], tries: int
) -> T:
    """What `attempt(amplitude) -> (share of what is wanted, result)` makes at the amplitude whose share is nearest to 1.

    The share need not be proportional, not even continuous: a slack sheet that forks moves far for a breath. So amplitudes on either
    side of 1 are kept, and once there are both, the next one lies between them.
    """
    amplitude, best = float(np.clip(usual, *limits)), (np.inf, None)
    below, above = 0.0, np.inf
    for _ in range(tries):
        share, result = attempt(amplitude)
        miss = abs(np.log(max(share, 1e-9)))
        best = min(best, (miss, result), key=lambda one: one[0])
        if miss < WITHIN:
            break
        below, above = (amplitude, above) if share < 1 else (below, amplitude)
        if below > 0 and np.isfinite(above):
            following = float(np.sqrt(below * above))
        else:
            following = float(np.clip(amplitude * np.clip(1 / max(share, 1e-9), 0.15, 6.0), *limits))
        if following == amplitude:
            break
        amplitude = following
    return best[1]
