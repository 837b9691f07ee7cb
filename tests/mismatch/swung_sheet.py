"""A sheet whose motion is given by formulas, not simulated: forces on it are what a test says, and noise."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from sim1.cloth.precise.marker_states import MarkerStates
from sim1.mismatch.missing_force import Forces

SIDE_M, ACROSS = 0.3, 5
STEP_S = 1 / 60
REMEMBERED_S = 0.08  # by noise, about as by springs of 1 Hz


def swung(number: int, duration_s: float = 4.0) -> Forces:
    """Held along its upper edge, swung to and fro, sideways and in waves; where it hangs lower than 0.26 m below the bar it lies on a table."""
    stream = np.random.default_rng(number)
    time = np.arange(0.0, duration_s, STEP_S)
    u, v = (part.ravel() for part in np.meshgrid(*(np.linspace(0.03, SIDE_M - 0.03, ACROSS),) * 2))
    ramp = np.clip(time / 0.5, 0.0, 1.0)

    def course(hz: float, size: float) -> np.ndarray:
        phase, other = stream.uniform(0.0, 2 * np.pi, 2)
        return ramp * size * (np.sin(2 * np.pi * hz * time + phase) + 0.5 * np.sin(2 * np.pi * 1.7 * hz * time + other))

    swing, wave = course(0.9 + 0.2 * number, 0.8)[:, None], course(1.9, 0.02)[:, None]
    side, sink = course(0.7, 0.05)[:, None], course(0.5, 0.03)[:, None]
    k = 3 * np.pi / (2 * SIDE_M)
    y = swing * v**2 / SIDE_M + wave * np.sin(k * v)
    y_v, y_vv = 2 * swing * v / SIDE_M + wave * k * np.cos(k * v), 2 * swing / SIDE_M - wave * k**2 * np.sin(k * v)
    path = np.stack([u + side * (1 + v / SIDE_M), y, 0.3 - v + sink + 0.0 * u], axis=-1)
    thread = np.stack([0.0 * y, y_v, -1.0 + 0.0 * y], axis=-1)
    thread /= np.linalg.norm(thread, axis=-1, keepdims=True)
    other = np.broadcast_to([1.0, 0.0, 0.0], thread.shape)
    stretch = 0.01 * (1 - v / SIDE_M) * (1 + 10.0 * wave)
    bent = y_vv / (1 + y_v**2) ** 1.5
    return Forces(
        name=f"swing_{number}",
        time_s=time,
        force_n=np.zeros_like(path),
        floor_n=0.0,
        path_m=path,
        states=MarkerStates(
            normal=np.cross(other, thread),
            threads=np.stack([other, thread], axis=2),
            strain=np.stack([-0.3 * stretch, stretch, 0.0 * stretch], axis=-1),
            curvature_1_m=np.stack([0.0 * bent, bent, 0.0 * bent], axis=-1),
            grip_m=np.broadcast_to(v, y.shape),
        ),
        table_z_m=0.04,
    )


def noise(one: Forces, size_n: float, seed: int) -> np.ndarray:
    """Noise (T, M, 3) of a root mean square that neighbouring steps share, markers not."""
    white = np.random.default_rng(seed).standard_normal(one.force_n.shape)
    smooth = gaussian_filter1d(white, REMEMBERED_S / STEP_S, axis=0)
    return size_n * smooth / np.sqrt((smooth**2).mean())


def pushed(
    force: Callable[[Forces], np.ndarray],
    noisy: float = 0.5,
    motions: int = 4,
    duration_s: float = 4.0,
    seed: int = 100,
) -> tuple[Forces, ...]:
    """Recordings in which a force acts, (T, M, 3) of each, and noise of `noisy` times its root mean square, 1 mN if there is none."""
    recordings = [swung(number, duration_s) for number in range(motions)]
    acts = [np.broadcast_to(force(one), one.force_n.shape) for one in recordings]
    floor_n = noisy * (float(np.sqrt(np.mean([part**2 for part in acts]))) or 1e-3)
    return tuple(
        replace(one, force_n=part + noise(one, floor_n, seed + k), floor_n=floor_n)
        for k, (one, part) in enumerate(zip(recordings, acts, strict=True))
    )
