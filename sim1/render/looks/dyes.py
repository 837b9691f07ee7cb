"""What happens to the colour of a patterned cloth in dyeing, washing and spinning.

Every function takes the colours (..., 3) that the pattern gave, place in metres (the garment's middle at the origin), the
palette (3, 3) of base, second and third colour, and a seed; it gives colours (..., 3). All colours are sRGB in [0, 1].
"""

import numpy as np

from sim1.render.looks.blocks import Kinds, Whole
from sim1.render.looks.noise import clouds, covered, step

PATCH = (0.001, 0.5)  # m
AMOUNT = (0.0, 1.0)
DYES = Kinds("dye")


@DYES.kind()
def even(color: np.ndarray, x: np.ndarray, y: np.ndarray, palette: np.ndarray, seed: int) -> np.ndarray:
    """Nothing."""
    return color


@DYES.kind(colors=2, amount=AMOUNT, fibre_m=PATCH)
def heather(
    color: np.ndarray, x: np.ndarray, y: np.ndarray, palette: np.ndarray, seed: int, *, amount: float, fibre_m: float
) -> np.ndarray:
    """Fibres of the second colour spun in: short flecks along x, over about `amount` of the cloth."""
    flecks = clouds(x / (3.0 * fibre_m), y / fibre_m, seed, octaves=2)
    return _mixed(color, palette[1], covered(amount, flecks, octaves=2, soft=0.07))


@DYES.kind(amount=AMOUNT, length_m=PATCH, width_m=PATCH)
def slub(
    color: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    palette: np.ndarray,
    seed: int,
    *,
    amount: float,
    length_m: float,
    width_m: float,
) -> np.ndarray:
    """Threads of uneven thickness: lighter and darker streaks in both directions."""
    streaks = clouds(x / length_m, y / width_m, seed) + clouds(x / width_m, y / length_m, seed + 1) - 1.0
    return np.clip(color * (1.0 + 0.5 * amount * streaks[..., None]), 0.0, 1.0)


@DYES.kind(colors=2, amount=AMOUNT, patch_m=PATCH)
def wash(
    color: np.ndarray, x: np.ndarray, y: np.ndarray, palette: np.ndarray, seed: int, *, amount: float, patch_m: float
) -> np.ndarray:
    """Patches bleached to the second colour, over about `amount` of the cloth, with hard and soft edges."""
    patches = clouds(x / patch_m, y / patch_m, seed, octaves=4)
    return _mixed(color, palette[1], covered(amount, patches, octaves=4, soft=0.09))


@DYES.kind(colors=2, reach_m=(0.05, 1.0), turn_deg=(-180.0, 180.0))
def ombre(
    color: np.ndarray, x: np.ndarray, y: np.ndarray, palette: np.ndarray, seed: int, *, reach_m: float, turn_deg: float
) -> np.ndarray:
    """Dipped: fades into the second colour over `reach_m` in a direction."""
    turn = np.radians(turn_deg)
    along = x * np.cos(turn) + y * np.sin(turn)
    return _mixed(color, palette[1], step(-0.5 * reach_m, 0.5 * reach_m, along))


@DYES.kind(colors=3, ring_m=(0.01, 0.5), twist=Whole(range(4)))
def tie_dye(
    color: np.ndarray, x: np.ndarray, y: np.ndarray, palette: np.ndarray, seed: int, *, ring_m: float, twist: float
) -> np.ndarray:
    """Rings of three colours about a knot near the middle, wound `twist` times into a spiral, bleeding at the edges."""
    knot = np.random.default_rng(seed).uniform(-0.12, 0.12, 2)
    radius, angle = np.hypot(x - knot[0], y - knot[1]), np.arctan2(y - knot[1], x - knot[0])
    bleed = 2.5 * (clouds(x / 0.04, y / 0.04, seed, octaves=3) - 0.5)
    phase = (radius / ring_m + 3.0 * twist * angle / (2.0 * np.pi) + bleed) % 3.0
    weights = np.stack([1.0 - step(0.35, 0.75, np.abs((phase - k + 1.5) % 3.0 - 1.5)) for k in range(3)], axis=-1)
    return weights @ palette / np.maximum(weights.sum(axis=-1, keepdims=True), 1e-9)


def _mixed(color: np.ndarray, other: np.ndarray, share: np.ndarray) -> np.ndarray:
    return color + share[..., None] * (other - color)
