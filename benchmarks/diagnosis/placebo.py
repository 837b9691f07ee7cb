"""Placebos must lose: every effect's fingerprint with its time, its places or its directions mixed up, screened as the true ones are.

What gains because it is one more thing to fit gains as much with a fingerprint that means nothing; what gains because it was
concealed does not. What acts alike at all times, or on all markers, is no placebo of itself when these are mixed: a tilt of gravity stays one.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.diagnosis.asked import each_once
from sim1.cloth.precise.world import World
from sim1.mismatch.engine import Engine
from sim1.mismatch.heldout import held_out
from sim1.mismatch.models import calibrate
from sim1.mismatch.screen import screen, site_of
from sim1.mismatch.search import baseline
from sim1.recording.bundle import Bundle

KINDS = ("time", "places", "directions")
SHIFTED = (0.25, 0.75)  # of a recording, by which fingerprints come late; what leaves at its end enters at its start


def mixed(moved_m: np.ndarray, kind: str, chance: np.random.Generator) -> np.ndarray:
    """Displacements (W, B, M, 3) of every twin, block and marker: later, at other markers, or turned, for all twins alike."""
    _, blocks, markers, _ = moved_m.shape
    if kind == "time":
        return np.roll(moved_m, round(blocks * chance.uniform(*SHIFTED)), axis=1)
    if kind == "places":
        return moved_m[:, :, chance.permutation(markers)]
    if kind == "directions":
        return moved_m @ Rotation.random(rng=chance).as_matrix().T
    raise ValueError(f"{kind!r}: one of {', '.join(KINDS)}")


class Mixing(Engine):
    """Tells effects' fingerprints mixed up, while it is asked to."""

    _how: tuple[str, int] | None = None

    @contextmanager
    def mixing(self, kind: str, seed: int) -> Iterator[None]:
        """Until the end of this."""
        self._how = kind, seed
        try:
            yield
        finally:
            self._how = None

    def answers(self, worlds: list[World], steps: np.ndarray, names: tuple[str, ...]) -> dict[str, np.ndarray]:
        """As the engine's, (K, W - 1) by recording."""
        if self._how is None:
            return super().answers(worlds, steps, names)
        kind, seed = self._how
        chance, told = np.random.default_rng(seed), {}
        for name, run in self._markers(worlds, names).items():
            one = self.observed(name)
            moved_m = np.zeros((len(steps), *one.kept.shape))  # where a marker was not seen, nothing moves
            moved_m[:, one.kept] = one.reduce((run[1:] - run[0]) / steps[:, None, None, None])
            told[name] = one.white(mixed(moved_m, kind, chance)[:, one.kept].T)
        return told


def gains(bundle: Bundle, seed: int) -> dict[str, dict[str, float]]:
    """Nats that screening foretells of every effect (`true`), and of the placebos of each kind, beside the calibrated baseline."""
    names = tuple(one.name for one in bundle.recordings if one.name != held_out(bundle))
    plain = baseline(bundle)
    found = {}
    with Mixing(bundle) as engine:
        base = calibrate(engine, plain, np.zeros(plain.count), names, lambda share: None)
        site = site_of(engine, base.unknowns.world(base.z))
        found["true"] = {one.term.effect.name: one.gain for one in screen(engine, base, site, names)}
        for kind in KINDS:
            with engine.mixing(kind, seed):
                found[kind] = {one.term.effect.name: one.gain for one in screen(engine, base, site, names)}
    return found


def placebos(folders: list[Path], out: Path, tell: Callable[[str], None], seed: int = 0) -> str:
    """A Markdown table: nats of what was concealed, of the best other effect, and of the best placebo of each kind, by case.

    Writes OUT/CASE.json after each case, and asks no case twice.
    """
    lines = [
        f"| concealed | its own | best of the others | {' | '.join(f'best with {kind} mixed' for kind in KINDS)} |",
        "| --- " * (3 + len(KINDS)) + "|",
    ]
    lost, asked = dict.fromkeys(KINDS, 0), 0
    for answers, found in each_once(folders, out, f"placebos of seed {seed}", lambda bundle: gains(bundle, seed), tell):
        concealed = [effect.name for effect in answers.effects]
        own = [found["true"][name] for name in concealed if name in found["true"]]
        others = [gain for name, gain in found["true"].items() if name not in concealed]
        best = {kind: max(found[kind].values()) for kind in KINDS}
        if own:
            asked += 1
            lost = {kind: lost[kind] + (max(own) > best[kind]) for kind in KINDS}
        cells = [f"{max(own):.0f}" if own else "-", f"{max(others):.0f}", *(f"{gain:.0f}" for gain in best.values())]
        lines.append(f"| {' + '.join(concealed) or 'nothing'} | {' | '.join(cells)} |")
    counts = ", ".join(f"with {kind} mixed in {lost[kind]}" for kind in KINDS)
    return "\n".join([*lines, "", f"Of {asked} cases with an effect of the table every placebo loses to it: {counts}."])
