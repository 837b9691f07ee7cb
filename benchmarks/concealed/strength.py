"""How strong an effect is, in the markers: measured, then set to what the strength's name promises."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.concealed.case import STRENGTHS, Case, Plan
from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.effects.library import LIBRARY
from benchmarks.concealed.film import Stage, Track, film
from benchmarks.concealed.imitation import CHECK_TIMES_S, Changes, imitations, own

USUAL = {"weak": 0.1, "medium": 1.0, "strong": 2.5}
"""Amplitude to begin with."""
WEAK_LEAST = 0.02
"""Of a recipe's smallest amplitude, that a weak effect may have: many are of medium strength near theirs."""
WITHIN = np.log(1.4)
CORRECTIONS = 2
"""Films of the laboratory's grid at an amplitude that was found on the bundle's own mesh."""
OTHER_STD = 3.0
"""How many times as strong the other effect of a pair might be."""

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
    """The case's effects, each as strong as the case asks, measured on the two motions out of three that show it best.

    Measured is what no fabric imitates, nor the other effect of a pair at up to `OTHER_STD` times its strength: the second is tuned beside the first,
    then the first once more beside the second. Also the tracks that were made with all of them on the way, those of a single effect, and how strong
    each came out, in units of the noise.
    """
    scale = scale_of(stage, {name: _shown(name, plan_list) for name in case.effects}, without)
    found: list[Tuned] = []
    for name in case.effects:
        scale = scale.beside(name, [one.effect for one in found])
        found.append(_tuned(case, scale, name, USUAL[case.strength], tries))
    if len(found) > 1:
        first, *later = case.effects
        scale = scale.beside(first, [one.effect for one in found[1:]])
        found[0] = _again(case, scale, first, found[0], tries)
        for number, name in enumerate(later, start=1):
            scale = scale.beside(name, [one.effect for one in found[:number]])
    strengths = [scale.strength(name, one.effect, one.films) for name, one in zip(case.effects, found, strict=True)]
    films = found[0].films if len(found) == 1 else {}
    return [one.effect for one in found], films, strengths


@dataclass(frozen=True)
class Tuned:
    """An effect at the amplitude that was found for it."""

    effect: Effect
    amplitude: float
    films: Films
    """Tracks with it alone of the motions that show it, on the laboratory's grid."""


@dataclass(frozen=True, kw_only=True)
class Scale:
    """How strong an effect is, in noise, beside what else could have done the same."""

    stage: Stage
    rough: Stage
    """The same on the bundle's own mesh: several times as fast."""
    shown: dict[str, list[Plan]]
    """By effect, motions that show it."""
    without: Films
    """Nothing concealed, on the laboratory's grid."""
    rough_without: Films
    """And on the bundle's own mesh."""
    imitated: Changes
    """By plan: (F, M, 3, P) what fabric, friction and places do, per spread."""
    others: dict[str, Changes]
    """By effect and plan: (F, M, 3, Q) what other effects do, `OTHER_STD` times as strong."""

    def beside(self, name: str, effects: Sequence[Effect]) -> "Scale":
        """A scale by which `name` counts for what none of these effects imitates."""
        if not effects:
            return self
        columns = {
            plan.name: np.stack([OTHER_STD * self.rough_change(effect, plan) for effect in effects], axis=-1)
            for plan in self.shown[name]
        }
        return replace(self, others={**self.others, name: columns})

    def rough_change(self, effect: Effect, plan: Plan) -> np.ndarray:
        """(F, M, 3) what it moves markers by on the bundle's own mesh."""
        without = self.rough_without[plan.name]
        return moves_m([effect], without if effect.measures_only else film(self.rough, plan, [effect]), without)

    def rough_strength(self, name: str, effect: Effect) -> float:
        """By films on the bundle's own mesh."""
        return self._own(name, {plan.name: self.rough_change(effect, plan) for plan in self.shown[name]})

    def strength(self, name: str, effect: Effect, films: Films) -> float:
        """By tracks of the laboratory's grid."""
        return self._own(name, {one: moves_m([effect], films[one], self.without[one]) for one in films})

    def films(self, name: str, effect: Effect) -> Films:
        """Tracks with it of the motions that show it."""
        still = effect.measures_only
        return {p.name: self.without[p.name] if still else film(self.stage, p, [effect]) for p in self.shown[name]}

    def _own(self, name: str, changes: Changes) -> float:
        others, noise = self.others.get(name, {}), self.stage.setting.noise_m
        known = {
            plan: np.concatenate([self.imitated[plan], others[plan]], axis=-1) if others else self.imitated[plan]
            for plan in changes
        }
        left = sorted(map(rms, own(changes, known, noise).values()))[-2:]
        return float(np.sqrt(np.mean(np.square(left)))) / noise


def scale_of(stage: Stage, shown: dict[str, list[Plan]], without: Films) -> Scale:
    """Film what there is to compare with: on the bundle's own mesh, a film for each motion and unknown."""
    rough = stage.coarser()
    plans = list({plan.name: plan for some in shown.values() for plan in some}.values())
    still: Films = {plan.name: film(rough, plan, []) for plan in plans}
    return Scale(
        stage=stage,
        rough=rough,
        shown=shown,
        without=without,
        rough_without=still,
        imitated=imitations(rough, plans, still) if plans else {},
        others={},
    )


def _shown(name: str, plan_list: Sequence[Plan]) -> list[Plan]:
    """Three motions that show an effect."""
    filmed = [plan for plan in plan_list if not plan.held_out]
    return ([plan for plan in filmed if plan.motion.name in LIBRARY[name].shown_by] or filmed)[:3]


def _tuned(case: Case, scale: Scale, name: str, usual: float, tries: int) -> Tuned:
    """Sought on the bundle's own mesh, from a usual amplitude on, then set right on the laboratory's grid."""
    recipe, wanted = LIBRARY[name], STRENGTHS[case.strength]

    def drawn(amplitude: float) -> Effect:
        return recipe.draw(amplitude, case.stream(name), scale.stage.setting)

    def rough(amplitude: float) -> tuple[float, float]:
        return scale.rough_strength(name, drawn(amplitude)) / wanted, amplitude

    def fine(amplitude: float) -> tuple[float, Tuned]:
        effect = drawn(amplitude)
        films = scale.films(name, effect)
        return scale.strength(name, effect, films) / wanted, Tuned(effect, amplitude, films)

    limits = amplitudes(name, case.strength)
    near = nearest_to_one(rough, usual, limits, tries)
    return nearest_to_one(fine, near, limits, CORRECTIONS)


def amplitudes(name: str, strength: str) -> tuple[float, float]:
    """Smallest and largest amplitude of an effect that is sought: a weak one may be as small as it must."""
    low, high = LIBRARY[name].amplitudes
    return (WEAK_LEAST * low if strength == "weak" else low), high


def _again(case: Case, scale: Scale, name: str, found: Tuned, tries: int) -> Tuned:
    """The first effect, which was tuned with nothing beside it: once more, where the others take so much of it that it is not as strong as asked."""
    share = max(scale.strength(name, found.effect, found.films) / STRENGTHS[case.strength], 1e-9)
    following = float(np.clip(found.amplitude / share, *amplitudes(name, case.strength)))
    if abs(np.log(share)) < WITHIN or following == found.amplitude:
        return found
    other = _tuned(case, scale, name, following, tries)
    instead = max(scale.strength(name, other.effect, other.films) / STRENGTHS[case.strength], 1e-9)
    return other if abs(np.log(instead)) < abs(np.log(share)) else found


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
