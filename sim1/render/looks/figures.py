"""What table tops and floors are made of: how much of each of three colours is at a place, in metres.

Every function gives weights (..., 3) that add up to 1, of base, second and third colour. Grain runs along x.
"""

import numpy as np

from sim1.render.looks.blocks import Kinds
from sim1.render.looks.noise import clouds, covered, scatter, step
from sim1.render.looks.weights import weights

SIZE = (0.0005, 1.0)  # m
SHARE = (0.0, 1.0)
FIGURES = Kinds("figure")


@FIGURES.kind()
def plain(x: np.ndarray, y: np.ndarray, seed: int) -> np.ndarray:
    """The base colour alone: lacquer."""
    return weights(np.zeros(x.shape))


@FIGURES.kind(colors=2, ring_m=SIZE, share=SHARE)
def grain(x: np.ndarray, y: np.ndarray, seed: int, *, ring_m: float, share: float) -> np.ndarray:
    """Wood: growth rings cut lengthwise, `ring_m` apart and bent by the tree's form, and pores."""
    bend = 6.0 * clouds(x / 0.9, y / 0.12, seed, octaves=2)
    wobble = 0.6 * clouds(x / 0.15, y / 0.01, seed + 1, octaves=2)
    ring = (y / ring_m + bend + wobble) % 1.0
    pores = step(0.6, 0.8, clouds(x / 0.03, y / 0.0015, seed + 2))
    return weights(np.clip(share * (ring**2 + 0.5 * pores), 0.0, 1.0))


@FIGURES.kind(colors=3, size_m=SIZE, share=SHARE)
def veins(x: np.ndarray, y: np.ndarray, seed: int, *, size_m: float, share: float) -> np.ndarray:
    """Marble: soft clouds of the third colour and sharp veins of the second along the folds of a warped field."""
    u, v = x / size_m, y / size_m
    du, dv = (2.0 * (clouds(u, v, seed + k, octaves=3) - 0.5) for k in (0, 1))
    field = clouds(u + 1.2 * du, 0.6 * v + 1.2 * dv, seed + 2, octaves=3)
    vein = share * (1.0 - step(0.0, 0.03, np.abs(field - 0.5)))
    fine = 0.5 * share * (1.0 - step(0.0, 0.02, np.abs(clouds(2.3 * u + du, 2.3 * v + dv, seed + 3, octaves=3) - 0.55)))
    cloud = 0.5 * share * step(0.4, 0.75, field)
    second = np.maximum(vein, fine)
    return weights(second, cloud * (1.0 - second))


@FIGURES.kind(colors=3, size_m=SIZE, share=SHARE)
def specks(x: np.ndarray, y: np.ndarray, seed: int, *, size_m: float, share: float) -> np.ndarray:
    """Grains or chips about `size_m` wide with straight edges, `share` of them of the second or third colour."""
    nearest, which = np.full(x.shape, np.inf), np.zeros(x.shape)
    i, j = np.floor(x / size_m), np.floor(y / size_m)
    for a in (-1, 0, 1):
        for b in (-1, 0, 1):
            u = i + a + scatter(i + a, j + b, seed) - x / size_m
            v = j + b + scatter(i + a, j + b, seed + 1) - y / size_m
            distance = u * u + v * v
            which = np.where(distance < nearest, scatter(i + a, j + b, seed + 2), which)
            nearest = np.minimum(distance, nearest)
    return weights((which < 0.5 * share).astype(float), ((which >= 0.5 * share) & (which < share)).astype(float))


@FIGURES.kind(colors=3, size_m=SIZE, share=SHARE, fleck_m=SIZE, flecks=SHARE)
def mottled(
    x: np.ndarray, y: np.ndarray, seed: int, *, size_m: float, share: float, fleck_m: float, flecks: float
) -> np.ndarray:
    """Clouds of the second colour, flecks of the third over about `flecks` of it: concrete, linoleum, felt, carpet."""
    cloud = share * step(0.3, 0.7, clouds(x / size_m, y / size_m, seed, octaves=5))
    fleck = covered(flecks, clouds(x / fleck_m, y / fleck_m, seed + 9, octaves=2), octaves=2, soft=0.05)
    return weights(cloud * (1.0 - fleck), fleck)


@FIGURES.kind(colors=2, width_m=SIZE, share=SHARE)
def brushed(x: np.ndarray, y: np.ndarray, seed: int, *, width_m: float, share: float) -> np.ndarray:
    """Fine scratches along x: metal."""
    return weights(share * clouds(x / (150.0 * width_m), y / width_m, seed, octaves=2))
