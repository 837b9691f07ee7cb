"""Sparse regression on forces, in the way of SINDy (Brunton et al. 2016), by PySINDy: what the calibrated baseline lacks as a sum of few effects.

The baseline is pulled along the measured markers; what pulls it is the force that it lacks, as far as springs tell. Both the force and
what every effect would push with along that motion are smoothed in time, as a difference of forces is mostly noise (the weak form, Messenger and
Bortz 2021). Thresholded least squares then picks columns. It knows no delay, clock, camera or grip: these are no forces on cloth.
"""

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d
from threadpoolctl import threadpool_limits

from sim1.cloth.physics import ClothPhysics
from sim1.cloth.precise.lacking import lacking_forces
from sim1.cloth.precise.pull import Goals, Pull
from sim1.cloth.precise.simulate import NotConverged, simulate
from sim1.cloth.precise.world import World
from sim1.mismatch.engine import Engine
from sim1.mismatch.heldout import rmse_of
from sim1.mismatch.model_file import with_grips, world_of
from sim1.mismatch.screen import site_of
from sim1.proof.baselines.dictionary import Entry, entries_of, world_with
from sim1.recording.bundle import Bundle
from sim1.stage import BadInput

# These four were chosen on the 16 opened cases of docs/campaigns.md, for the most right answers over single effects and nulls: 8 of 12. With springs
# of 2 Hz no choice of the others found more; with 6 Hz, tried on nine cases, the best had 3 of 6 in place of 5. Without smoothing no single was
# right; 0.2 or 0.4 s is a case worse. A threshold of 0.13 costs a null, one of 0.17 both singles.
FOLLOW_HZ = 2.0  # of the springs
SMOOTH_S = 0.3  # standard deviation of the bell
RIDGE = 0.5  # in units of the sum of squares of a column
THRESHOLD = 0.15  # share of the missing force that a column must carry, both as root mean squares
SILENT_N = 1e-9  # a column with less in it (root mean square) is none: nothing rubs on a table that is never touched
ENDS_S = 0.3  # the pull fades at the end of a recording, beyond the last frame


@dataclass(frozen=True, kw_only=True)
class Regression:
    """What was regressed: forces at markers and the dictionary's columns, smoothed."""

    entries: list[Entry]
    columns: np.ndarray  # (N, C) [N]
    missing: np.ndarray  # (N,) [N]


@dataclass(frozen=True, kw_only=True)
class Named:
    """What a sparse regression says."""

    effects: tuple[str, ...]
    heldout_m: float | None  # of the baseline with these effects; None: no simulation of it found its way


def sparse_effects(bundle: Bundle, physics: ClothPhysics, held: str) -> Named:
    """Names by sparse regression on all recordings but `held`, beside the calibrated model `physics`, and its error on that one.

    Raises:
        BadInput: PySINDy is not installed.
        NotConverged: a recording that the baseline cannot follow.
    """
    bundle = with_grips(bundle, physics)
    plain = world_of(physics, bundle)
    with Engine(bundle) as engine:
        with threadpool_limits(1):  # the matrices are small
            given = regression(engine, plain, tuple(name for name in engine.names if name != held))
        world, names = chosen(plain, given)
        try:
            markers = engine.foretell(world, (held,))
        except NotConverged:
            return Named(effects=names, heldout_m=None)
    return Named(effects=names, heldout_m=rmse_of(bundle, markers, (held,)))


def regression(engine: Engine, plain: World, names: tuple[str, ...]) -> Regression:
    """Missing forces and columns of some recordings.

    Raises:
        NotConverged: a recording that the baseline cannot follow.
    """
    recordings, runs = {recording.name: recording for recording in engine.bundle.recordings}, {}
    for name in names:
        goals = Goals.of(recordings[name].time_s, recordings[name].markers_m)
        runs[name] = simulate(engine.stages[name].scene, [plain], pull=Pull(hz=FOLLOW_HZ, goals=goals))
        engine.stages[name].rest_m = runs[name].rest_m
    entries = entries_of(plain, site_of(engine, plain))
    columns, missing = [], []
    for name, run in runs.items():
        scene = engine.stages[name].scene
        pushes = lacking_forces(scene, [entry.world for entry in entries], plain, run.shapes_m)
        both = np.concatenate([pushes, run.pull_n[None]])  # (C + 1, T, M, 3)
        kept = smoothed(both, scene.step_s).reshape(len(both), -1)
        columns.append(kept[:-1].T)
        missing.append(kept[-1])
    return Regression(entries=entries, columns=np.concatenate(columns), missing=np.concatenate(missing))


def smoothed(forces_n: np.ndarray, step_s: float) -> np.ndarray:
    """Forces (C, T, M, 3) under a bell of `SMOOTH_S`, a sample for each of its widths; without the end, where nothing pulls."""
    width = SMOOTH_S / step_s
    inside = forces_n[:, 1 : forces_n.shape[1] - round(ENDS_S / step_s)]
    return gaussian_filter1d(inside, width, axis=1, mode="nearest")[:, :: max(round(width), 1)]


def chosen(plain: World, given: Regression) -> tuple[World, tuple[str, ...]]:
    """The world with what the regression picks, and the names of the effects in it.

    Raises:
        BadInput: PySINDy is not installed.
    """
    sizes = np.sqrt(np.mean(given.columns**2, axis=0))
    heard = np.flatnonzero(sizes > SILENT_N)
    size = float(np.sqrt(np.mean(given.missing**2)))
    shares = np.zeros(len(sizes))
    if len(heard) and size > 0.0:
        shares[heard] = sparse(given.columns[:, heard] / sizes[heard], given.missing / size) * size / sizes[heard]
    return world_with(plain, given.entries, shares, sizes)


def sparse(columns: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Coefficients (C,) of columns (N, C), all of size 1 as the target (N,) is, by PySINDy's thresholded least squares.

    Raises:
        BadInput: PySINDy is not installed.
    """
    least_squares = pysindy_stlsq()
    with warnings.catch_warnings():
        # That no column is left is an answer.
        warnings.filterwarnings("ignore", message="Sparsity parameter is too big")
        found = least_squares(threshold=THRESHOLD, alpha=RIDGE * len(target)).fit(columns, target[:, None])
    return np.asarray(found.coef_)[0]


def pysindy_stlsq() -> type:
    """PySINDy's sequentially thresholded least squares.

    Raises:
        BadInput: PySINDy is not installed.
    """
    try:
        from pysindy import STLSQ
    except ImportError as error:
        raise BadInput(
            "--baselines: sparse regression needs PySINDy, which is not installed; `make setup` installs it with the dev extra"
        ) from error
    return STLSQ
