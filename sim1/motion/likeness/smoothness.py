"""How smooth and how direct one movement of one tool is, in numbers that do not depend on its size or duration."""

import numpy as np
from scipy.signal import find_peaks

from sim1.episode import RATE_HZ

SPARC_CUT_OFF_HZ = 10.0  # omega_c of Balasubramanian et al. 2015: movements hold nothing above
SPARC_THRESHOLD = 0.05  # of the spectrum's maximum; the arc ends where the spectrum stays below
SPARC_PADDING = 4  # powers of two by which the spectrum is made finer
PEAK_PROMINENCE = 0.1  # of the movement's highest speed; a smaller bump is no movement of its own


def speed(position_m: np.ndarray) -> np.ndarray:
    """Speed (n - 1,) [m/s] over the frame steps of positions (n, 3)."""
    return np.linalg.norm(np.diff(position_m, axis=0), axis=-1) * RATE_HZ


def log_dimensionless_jerk(position_m: np.ndarray) -> float:
    """-ln(T^3 / v_peak^2 * integral of |jerk|^2) of positions (n, 3), n > 3; minimum jerk at rest at both ends has -5.32.

    Source: Hogan and Sternad 2009; Balasubramanian et al. 2015, equation for LDLJ-V. Third differences stand for the jerk.
    """
    jerk = np.diff(position_m, n=3, axis=0) * RATE_HZ**3
    duration_s = (len(position_m) - 1) / RATE_HZ
    # Third differences cover n - 3 of the n - 1 frame steps: their mean times the duration is the integral.
    integral = (jerk**2).sum(axis=-1).mean() * duration_s
    return -float(np.log(duration_s**3 * integral / speed(position_m).max() ** 2))


def spectral_arc_length(speed_m_s: np.ndarray, rate_hz: float = RATE_HZ) -> float:
    """SPARC of a speed profile (n,): minus the length of its normalised spectrum's curve; nearer to 0 is smoother.

    Source: Balasubramanian, Melendez-Calderon and Burdet 2012; Balasubramanian et al. 2015, section on SPARC.
    """
    size = 2 ** (int(np.ceil(np.log2(len(speed_m_s)))) + SPARC_PADDING)
    spectrum = np.abs(np.fft.rfft(speed_m_s, size))
    frequency = np.arange(len(spectrum)) * rate_hz / size
    keep = frequency <= SPARC_CUT_OFF_HZ
    spectrum, frequency = spectrum[keep] / spectrum.max(), frequency[keep]
    last = int(np.flatnonzero(spectrum >= SPARC_THRESHOLD)[-1])
    spectrum, frequency = spectrum[: last + 1], frequency[: last + 1]
    run = np.diff(frequency) / (frequency[-1] - frequency[0])
    return -float(np.hypot(run, np.diff(spectrum)).sum())


def path_ratio(position_m: np.ndarray) -> float:
    """Length of the way (n, 3) over the straight line between its ends; 1 is straight."""
    straight = float(np.linalg.norm(position_m[-1] - position_m[0]))
    return float(np.linalg.norm(np.diff(position_m, axis=0), axis=-1).sum()) / max(straight, 1e-9)


def speed_peaks(position_m: np.ndarray) -> int:
    """Number of peaks of the speed whose prominence is at least PEAK_PROMINENCE of the highest speed."""
    profile = speed(position_m)
    return len(find_peaks(profile, prominence=PEAK_PROMINENCE * profile.max())[0])


def turned_rad(position_m: np.ndarray) -> float:
    """Angle by which the direction of travel turns in all [rad]: the integral of curvature along the way (n, 3).

    Frame steps slower than a tenth of the fastest have no reliable direction and are left out.
    """
    steps = np.diff(position_m, axis=0)
    length = np.linalg.norm(steps, axis=-1)
    fast = length > 0.1 * length.max()
    direction = steps[fast] / length[fast, None]
    return float(np.arccos(np.clip((direction[1:] * direction[:-1]).sum(axis=-1), -1, 1)).sum())
