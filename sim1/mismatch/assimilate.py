"""Where and when physics is missing, as a force at every marker.

While nothing is named: the force that it takes to keep the calibrated simulation on the measured markers. Soft springs and dampers pull
every simulated marker to its place; what they pull is the force that the model lacks, in newtons, without a double derivative of noisy
data. It counts only above what the same springs pull when the simulator is right and the markers carry the same noise.

Once physics is named: what it pushes with, along the motion of the model that has it. Where it acts through grips or clocks alone, stiff
springs to that model's markers, which carry no noise.
"""

from dataclasses import dataclass, replace

import numpy as np

from sim1.cloth.precise.lacking import cloth_part
from sim1.cloth.precise.pull import Goals
from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import Fit
from sim1.mismatch.missing_force import Forces
from sim1.mismatch.state import State, asked_of, table_of
from sim1.mismatch.state_words import words_of
from sim1.mismatch.workers import Done, Task
from sim1.recording.bundle import Recording

STIFF_HZ = 6.0  # of springs towards goals without noise
WINDOW_S = 0.2
WINDOWS_SHOWN = 3
REGION_SHARE = 0.5  # the fewest markers that carry this share of the missing force form the region


@dataclass(frozen=True, kw_only=True)
class Window:
    """A stretch of time in a recording and its share of the missing force."""

    recording: str
    from_s: float
    to_s: float
    share: float


@dataclass(frozen=True, kw_only=True)
class Located:
    """Missing force by place and time."""

    forces: tuple[Forces, ...]
    marker_power_n2: np.ndarray  # (M,) mean square above the floor
    windows: tuple[Window, ...]
    signature: str
    states: tuple[State, ...]  # what the force depends on and what it does not
    lost: dict[str, str]  # recordings that are not in it, and why

    def region(self) -> tuple[list[int], float]:
        """Columns of the fewest markers that carry half of it, and their share."""
        return _region(self.marker_power_n2)

    def worst_windows(self) -> list[Window]:
        """The windows with the largest shares."""
        return sorted((w for w in self.windows if w.share > 0), key=lambda w: -w.share)[:WINDOWS_SHOWN]


def locate_forces(engine: Engine, found: Fit, names: tuple[str, ...]) -> Located:
    """What a model without the effects of `found` would have to be pushed with to do as the recordings do.

    Recordings that no simulation follows are left out and told (`lost`).
    """
    lost: dict[str, str] = {}
    model, plain = found.unknowns.world(found.z), found.unknowns.with_terms().world(found.nominal_z)
    tasks = [replace(engine.task(name, plain), paths=True) for name in names]
    if cloth_part(model, plain) != plain:
        tasks = [replace(engine.task(name, model), paths=True, lacks=plain) for name in names]
    elif model != plain:
        goals = _those_found(engine, [engine.task(name, model) for name in names], lost)
        tasks = [
            replace(task, follow_hz=STIFF_HZ, goals_m=goals[task.recording].markers_m[0])
            for task in tasks
            if task.recording in goals
        ]
    recordings = {recording.name: recording for recording in engine.bundle.recordings}
    kg = plain.area_density_kg_m2 * engine.area_m2 / len(engine.bundle.anchors.marker)
    forces = []
    for name, run in _those_found(engine, tasks, lost).items():
        recording, number = recordings[name], names.index(name)
        seen = engine.stages[name].scene.time_s <= recording.time_s[-1]  # simulations go on for clocks that differ
        time = engine.stages[name].scene.time_s[seen]
        floor_n = 0.0
        if model == plain:
            floor_n = _floor_n(recording, _raw_noise(engine, recording), kg, engine.follow_hz, number)
        forces.append(
            Forces(
                name=name,
                time_s=time,
                force_n=run.force_n[seen],
                floor_n=floor_n,
                path_m=run.path_m[seen],
                states=run.states.at(seen),
                table_z_m=plain.table_z_m,
            )
        )
    return _summary(tuple(forces), lost)


def _those_found(engine: Engine, tasks: list[Task], lost: dict[str, str]) -> dict[str, Done]:
    """Answers by recording; those that found no way are added to `lost`."""
    runs = {task.recording: run for task, run in zip(tasks, engine.attempted(tasks), strict=True)}
    lost |= {name: str(run) for name, run in runs.items() if isinstance(run, NotConverged)}
    return {name: run for name, run in runs.items() if not isinstance(run, NotConverged)}


def _raw_noise(engine: Engine, recording: Recording) -> float:
    rate = 1.0 / float(np.median(np.diff(recording.time_s)))
    return engine.observed(recording.name).noise_m * float(np.sqrt(max(1.0, 0.04 * rate)))


def _floor_n(recording: Recording, noise_m: float, kg: float, hz: float, seed: int) -> float:
    """Force (rms per coordinate) that springs feel when nothing but noise moves their goals; the sheet hardly follows it."""
    shake = np.random.default_rng(seed).standard_normal((len(recording.time_s), 8, 3)) * noise_m
    goals = Goals.of(recording.time_s, shake)
    place, speed = (np.stack([curve[k](recording.time_s[5:-5]) for curve in goals.curves]) for k in range(2))
    omega = 2 * np.pi * hz
    return float(kg * np.sqrt(np.mean((omega**2 * place + 2 * omega * speed) ** 2)))


def _summary(forces: tuple[Forces, ...], lost: dict[str, str]) -> Located:
    if not forces:
        return Located(
            forces=(),
            marker_power_n2=np.zeros(0),
            windows=(),
            signature="Where and when could not be told: no recording can be simulated along its markers.",
            states=(),
            lost=lost,
        )
    power = np.mean([np.maximum((f.force_n**2).mean((0, 2)) - f.floor_n**2, 0.0) for f in forces], axis=0)
    windows, total = [], 0.0
    for f in forces:
        for start in np.arange(f.time_s[0], f.time_s[-1], WINDOW_S):
            rows = (f.time_s >= start) & (f.time_s < start + WINDOW_S)
            excess = max(float((f.force_n[rows] ** 2).mean() - f.floor_n**2), 0.0)
            windows.append((f.name, float(start), float(min(start + WINDOW_S, f.time_s[-1])), excess))
            total += excess
    place = np.zeros(len(power), bool)
    place[_region(power)[0]] = True
    asked = asked_of(forces, place)
    return Located(
        forces=forces,
        marker_power_n2=power,
        windows=tuple(
            Window(recording=n, from_s=a, to_s=b, share=min(e / total, 1.0) if total else 0.0) for n, a, b, e in windows
        ),
        signature=f"{_size(forces)}; {words_of(asked)}.",
        states=table_of(asked),
        lost=lost,
    )


def _region(power: np.ndarray) -> tuple[list[int], float]:
    """The fewest markers that carry `REGION_SHARE` of a mean square (M,) together, and their share; none where there is none."""
    if power.sum() <= 0:
        return [], 0.0
    order = np.argsort(-power, kind="stable")
    share = np.cumsum(power[order]) / power.sum()
    count = int(np.argmax(share >= REGION_SHARE)) + 1
    return sorted(int(k) for k in order[:count]), float(min(share[count - 1], 1.0))


def _size(forces: tuple[Forces, ...]) -> str:
    size = float(np.sqrt(np.concatenate([f.force_n.ravel() ** 2 for f in forces]).mean()))
    floor = float(np.sqrt(np.mean([f.floor_n**2 for f in forces])))
    told = f"(noise alone {1e3 * floor:.2f} mN)" if floor else "to move as the model with it does"
    return f"The markers need a force of {1e3 * size:.2f} mN each {told}"
