"""The identification simulator with the true parameters beside the recordings: what is left is noise, or what the simulator gets wrong."""

from pathlib import Path

import numpy as np

from benchmarks.diagnosis.asked import answers_of, bundle_of
from sim1.cloth.effects import EFFECTS
from sim1.cloth.precise.pull import Goals, Pull
from sim1.cloth.precise.scene import prepare
from sim1.cloth.precise.simulate import NotConverged, simulate
from sim1.cloth.precise.world import World
from sim1.mismatch.compare import Observed, block_noise_m, observe
from sim1.mismatch.engine import FINE_STEP_S, FOLLOW_HZ
from sim1.proof.answers import Answers
from sim1.proof.oracle import as_told, concealed
from sim1.recording.bundle import Bundle, Recording, read_bundle

KINDS = {
    "as given, free": (0, 0.0),
    "as given": (0, FOLLOW_HZ),
    "refined, free": (1, 0.0),
    "refined": (1, FOLLOW_HZ),
    "refined twice": (2, FOLLOW_HZ),
}
CHANGES = {"refining changes": ("as given", "refined"), "once more": ("refined", "refined twice")}


def at_truth(folder: Path, step_s: float = FINE_STEP_S) -> str:
    """A Markdown table: rms of measured less simulated [mm], means of 40 ms, by recording and kind of simulation, and of what refining changes.

    Places of grips that the bundle does not give are estimated from the markers at rest, not true. Effects outside of the table are not
    simulated, as there is no formula for them; a line says so.

    Args:
        folder: a laboratory's case.
        step_s: of every simulation.

    Raises:
        BadInput: bundle or answers are missing or damaged.
    """
    bundle = read_bundle(bundle_of(folder))
    answers = answers_of(folder)
    world = _true_world(bundle, answers)
    unknown = [effect.name for effect in answers.effects if effect.name not in EFFECTS]
    observed = [observe(recording) for recording in bundle.recordings]
    noise = block_noise_m(observed, list(bundle.recordings)) or float("nan")
    lines = [
        f"{folder.name}, noise {1e3 * noise:.2f} mm, steps of 1/{1 / step_s:.0f} s",
        *([f"not simulated, as it is outside of the table: {', '.join(unknown)}"] if unknown else []),
        "",
        f"| recording | {' | '.join((*KINDS, *CHANGES))} |",
        "| --- " * (1 + len(KINDS) + len(CHANGES)) + "|",
    ]
    for recording, one in zip(bundle.recordings, observed, strict=True):
        runs = {label: _blocks(bundle, recording, one, world, step_s, *kind) for label, kind in KINDS.items()}
        row = [_apart(run, one.measured_m) for run in runs.values()]
        row += [_apart(runs[coarse], runs[fine]) for coarse, fine in CHANGES.values()]
        lines.append(f"| {recording.name} | {' | '.join(row)} |")
    return "\n".join(lines)


def _true_world(bundle: Bundle, answers: Answers) -> World:
    effects = {name: values for name, values in concealed(answers).items() if name in EFFECTS}
    model, z = as_told(bundle, effects, answers.baseline)
    return model.world(z)


def _blocks(
    bundle: Bundle, recording: Recording, one: Observed, world: World, step_s: float, finer: int, hz: float
) -> np.ndarray | None:
    """Means (K,) of the simulated markers; None where no simulation follows."""
    pull = Pull(hz=hz, goals=Goals.of(recording.time_s, recording.markers_m)) if hz else None
    try:
        run = simulate(prepare(bundle, recording, step_s, finer), [world], pull=pull)
    except NotConverged:
        return None
    return one.reduce(run.markers_m[0])


def _apart(a_m: np.ndarray | None, b_m: np.ndarray | None) -> str:
    return "not converged" if a_m is None or b_m is None else f"{1e3 * np.sqrt(np.square(a_m - b_m).mean()):.2f}"
