"""How strong an effect is, in the markers: measured, then set to what the strength's name promises."""

from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.concealed.case import STRENGTHS, Case, Plan
from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.effects.library import LIBRARY
from benchmarks.concealed.film import Stage, Track, film
from benchmarks.concealed.motions.motion import DURATION_S

Films = dict[str, Track]
"""Tracks by the plan's name."""


def change_m(effects: Sequence[Effect], with_them: Track, without: Track) -> float:
    """Root mean square change of a marker's reported coordinate over one recording."""
    moves = reported(effects, with_them, CHECK_TIMES_S) - reported([], without, CHECK_TIMES_S)
    return float(np.sqrt((moves**2).mean()))


CHECK_TIMES_S = np.arange(0, DURATION_S, 0.01)


def reported(effects: Sequence[Effect], track: Track, stamps_s: np.ndarray) -> np.ndarray:
    """(F, M, 3) what the cameras report without noise, at stamps (F,)."""
    stamps = np.repeat(stamps_s[:, None], track.places_m.shape[1], axis=1)
    sample = track.sample
    for effect in effects:
        sample = _observed(effect, sample)
    return sample(stamps)


def _observed(effect: Effect, sample: Callable[[np.ndarray], np.ndarray]) -> Callable[[np.ndarray], np.ndarray]:
    return lambda stamps: effect.observe(stamps, sample)


def tuned(case: Case, stage: Stage, plan_list: Sequence[Plan], without: Films, tries: int = 4) -> list[Effect]:
    """The case's effects, each as strong alone as the case asks, measured on the motions that show it best."""
    return [_tuned(case, stage, plan_list, without, name, tries) for name in case.effects]


def _tuned(case: Case, stage: Stage, plan_list: Sequence[Plan], without: Films, name: str, tries: int) -> Effect:
    recipe = LIBRARY[name]
    low, high = recipe.amplitudes
    target = STRENGTHS[case.strength] * stage.setting.noise_m
    shown = [plan for plan in plan_list if plan.motion.name in recipe.shown_by and not plan.held_out][:2]
    amplitude = float(np.clip({"weak": 0.3, "medium": 1.0, "strong": 2.5}[case.strength], low, high))
    effect = recipe.draw(amplitude, case.stream(name), stage.setting)
    for _ in range(tries):
        found = [
            change_m([effect], without[p.name] if effect.measures_only else film(stage, p, [effect]), without[p.name])
            for p in shown
        ]
        ratio = target / max(float(np.sqrt(np.mean(np.square(found)))), 1e-9)
        if 0.7 < ratio < 1.4:
            break
        following = float(np.clip(amplitude * np.clip(ratio, 0.15, 6.0), low, high))
        if following == amplitude:
            break
        amplitude = following
        effect = recipe.draw(amplitude, case.stream(name), stage.setting)
    return effect
