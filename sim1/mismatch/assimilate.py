"""Where and when physics is missing: the force that it takes to keep the calibrated simulation on the measured markers.

Soft springs and dampers pull every simulated marker towards its measured place; what they have to pull is the force that the
model lacks, in newtons, without a double derivative of noisy data. It counts only above what the same springs pull when the
simulator is right and the markers carry the same noise.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

from sim1.cloth.precise.scene import Scene
from sim1.cloth.precise.simulate import NotConverged, Pull, simulate
from sim1.cloth.precise.world import World
from sim1.mismatch.engine import Engine
from sim1.mismatch.locate import REGION_SHARE, WINDOW_S, WINDOWS_SHOWN, Window
from sim1.recording.bundle import Recording

FOLLOW_HZ = 3.0  # how fast a marker follows its spring; slower than noise, faster than what a sheet's swing lacks
SMOOTH_S = 0.02


@dataclass(frozen=True, kw_only=True)
class Forces:
    """Missing force in one recording."""

    name: str
    time_s: np.ndarray  # (T,)
    force_n: np.ndarray  # (T, M, 3)
    floor_n: float  # rms per coordinate that noise alone makes
    velocity_m_s: np.ndarray  # (T, M, 3) of the assimilated markers


@dataclass(frozen=True, kw_only=True)
class Located:
    """Missing force by place and time."""

    forces: tuple[Forces, ...]
    marker_power_n2: np.ndarray  # (M,) mean square above the floor
    windows: tuple[Window, ...]
    signature: str

    def region(self) -> tuple[list[int], float]:
        """Columns of the fewest markers that carry half of it, and their share."""
        total = self.marker_power_n2.sum()
        if total <= 0:
            return [], 0.0
        order = np.argsort(-self.marker_power_n2, kind="stable")
        share = np.cumsum(self.marker_power_n2[order]) / total
        count = int(np.argmax(share >= REGION_SHARE)) + 1
        return sorted(int(k) for k in order[:count]), float(min(share[count - 1], 1.0))

    def worst_windows(self) -> list[Window]:
        """The windows with the largest shares."""
        return sorted((w for w in self.windows if w.share > 0), key=lambda w: -w.share)[:WINDOWS_SHOWN]


def locate_forces(engine: Engine, world: World, names: tuple[str, ...]) -> Located:
    """Assimilate recordings into `world`, then the same with markers that the world itself made, plus noise."""
    found = []
    for number, name in enumerate(names):
        stage = engine.stages[name]
        recording = next(r for r in engine.bundle.recordings if r.name == name)
        try:
            forces, velocity = _assimilated(stage.coarse, world, recording.markers_m, engine, stage.rest_m)
            twin = simulate(stage.coarse, [world], near=stage.rest_m).markers_m[0]
            noise = np.random.default_rng(number).standard_normal(twin.shape) * _raw_noise(engine, recording)
            twin[~recording.seen] = np.nan
            floor, _ = _assimilated(stage.coarse, world, twin + noise, engine, stage.rest_m)
        except NotConverged:
            continue
        found.append(
            Forces(
                name=name,
                time_s=stage.coarse.time_s,
                force_n=forces,
                floor_n=float(np.sqrt(np.mean(floor**2))),
                velocity_m_s=velocity,
            )
        )
    return _summary(tuple(found))


def _raw_noise(engine: Engine, recording: Recording) -> float:
    rate = 1.0 / float(np.median(np.diff(recording.time_s)))
    return engine.noise_m * float(np.sqrt(max(1.0, 0.04 * rate)))


def _assimilated(
    scene: Scene, world: World, markers: np.ndarray, engine: Engine, near
) -> tuple[np.ndarray, np.ndarray]:
    mass = world.area_density_kg_m2 * scene.sheet.face_area_m2.sum() / markers.shape[1]
    omega = 2 * np.pi * FOLLOW_HZ
    goal, speed = _goals(scene, markers)
    pull = Pull(stiffness_n_m=mass * omega**2, damping_n_s_m=2 * mass * omega, goal_m=goal, goal_m_s=speed)
    run = simulate(scene, [world], near=near, pull=pull)
    path = (run.shapes_m[:, scene.net.marker_node] * scene.net.marker_weight[..., None]).sum(2)
    return run.pull_n, np.gradient(path, scene.time_s, axis=0)


def _goals(scene: Scene, markers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Smoothed places and velocities (T, M, 3) of the markers at the steps; NaN in long gaps."""
    time = scene.frame_s
    rate = 1.0 / float(np.median(np.diff(time)))
    goal, speed = np.full((2, len(scene.time_s), markers.shape[1], 3), np.nan)
    for m in range(markers.shape[1]):
        seen = np.isfinite(markers[:, m, 0])
        if seen.sum() < 8:
            continue
        filled = np.stack([np.interp(time, time[seen], markers[seen, m, k]) for k in range(3)], axis=1)
        curve = CubicSpline(time, gaussian_filter1d(filled, SMOOTH_S * rate, axis=0, mode="nearest"))
        at = np.clip(scene.time_s, time[0], time[-1])
        near = np.abs(time[seen][:, None] - scene.time_s[None]).min(0) < 0.1
        goal[near, m], speed[near, m] = curve(at)[near], curve(at, 1)[near]
    ends = (scene.time_s < time[0] + 2 * SMOOTH_S) | (scene.time_s > time[-1] - 2 * SMOOTH_S)
    goal[ends] = np.nan  # smoothing bends the path at its ends, which would pass for a force
    return goal, np.where(np.isfinite(goal), speed, np.nan)


def _summary(forces: tuple[Forces, ...]) -> Located:
    if not forces:
        return Located(
            forces=(), marker_power_n2=np.zeros(0), windows=(), signature="No recording could be assimilated."
        )
    power = np.mean([np.maximum((f.force_n**2).mean((0, 2)) - f.floor_n**2, 0.0) for f in forces], axis=0)
    windows, total = [], 0.0
    for f in forces:
        for start in np.arange(f.time_s[0], f.time_s[-1], WINDOW_S):
            rows = (f.time_s >= start) & (f.time_s < start + WINDOW_S)
            excess = max(float((f.force_n[rows] ** 2).mean() - f.floor_n**2), 0.0)
            windows.append((f.name, float(start), float(min(start + WINDOW_S, f.time_s[-1])), excess))
            total += excess
    return Located(
        forces=forces,
        marker_power_n2=power,
        windows=tuple(
            Window(recording=n, from_s=a, to_s=b, share=min(e / total, 1.0) if total else 0.0) for n, a, b, e in windows
        ),
        signature=_signature(forces),
    )


def _signature(forces: tuple[Forces, ...]) -> str:
    """What the missing force depends on, in one sentence."""
    force = np.concatenate([f.force_n.reshape(-1, 3) for f in forces])
    velocity = np.concatenate([f.velocity_m_s.reshape(-1, 3) for f in forces])
    size, floor = float(np.sqrt((force**2).mean())), float(np.sqrt(np.mean([f.floor_n**2 for f in forces])))
    speed = np.linalg.norm(velocity, axis=1)
    moving = speed > max(0.05, float(np.quantile(speed, 0.5)))
    unit = velocity[moving] / speed[moving][:, None]
    along = (force[moving] * unit).sum(1)
    share = float((along**2).sum() / max((force[moving] ** 2).sum(), 1e-30))
    brakes = float(np.mean(along < 0))
    slow = float(np.sqrt((force[speed <= np.quantile(speed, 0.3)] ** 2).mean()))
    fast = float(np.sqrt((force[speed >= np.quantile(speed, 0.7)] ** 2).mean()))
    steady = np.linalg.norm(force.mean(0)) / max(size * np.sqrt(3), 1e-30)
    return (
        f"The markers need {1e3 * size:.2f} mN each (noise alone {1e3 * floor:.2f} mN); {100 * share:.0f} % of it lies along the motion "
        f"(33 % if direction played no part) and brakes {100 * brakes:.0f} % of the time; it is {fast / max(slow, 1e-12):.1f} times as large "
        f"where markers are fast as where they are slow, and {100 * steady:.0f} % of it is one constant push."
    )
