"""Which share of a force fields explain by least squares, and how often chance explains as much.

All is asked of sums over stretches of time, as forces of neighbouring markers and steps are no independent witnesses. Where a force has
nothing to do with a field, its sign in a stretch is as likely the other one: signs of whole stretches are drawn, in what the fields that
are known already leave (the wild bootstrap of scores, by clusters: Cameron, Gelbach and Miller 2008; Kline and Santos 2012). A steady push
has a sign, too, where a shuffle in time would leave it as it is. What a share could be is told by stretches drawn with replacement.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sim1.mismatch.missing_force import Forces

STRETCH_S = 0.5  # springs of 1 Hz have forgotten what they felt before
FLIPS, DRAWS, SEED = 999, 299, 7
LEAST_ABOVE = (
    0.1  # of a force's square, taken to be above the noise where less is: shares of next to nothing say nothing
)
RIDGE = 1e-9  # of the sum of all fields' squares: a field that is nowhere in a draw explains nothing there

type Fields = Callable[[Forces], np.ndarray]
"""Of a recording's T steps and M markers, K fields (K, T, M, 3), each in a unit of its own."""


@dataclass(frozen=True, kw_only=True)
class Shares:
    """Sums over S stretches: of K fields, scaled to a mean square of 1 at most, with one another and with the force."""

    gram: np.ndarray  # (S, K, K)
    pull: np.ndarray  # (S, K) [N]
    power: np.ndarray  # (S,) of the force's square [N^2]
    above: np.ndarray  # (S,) of that, what is above the noise
    scale: np.ndarray  # (K,) root mean square of each field before; 0: it is nowhere

    @classmethod
    def of(cls, forces: tuple[Forces, ...], fields: Fields) -> "Shares":
        """From all recordings; at least one."""
        parts = [part for one in forces for part in _stretches(one, fields(one))]
        gram, pull, power, count, noise = (np.array(column) for column in zip(*parts, strict=True))
        scale = np.sqrt(np.diagonal(gram.sum(0)) / count.sum())
        size = np.where(scale > 0.0, scale, 1.0)
        return cls(
            gram=gram / np.outer(size, size), pull=pull / size, power=power, above=power - count * noise, scale=scale
        )

    @cached_property
    def total(self) -> float:
        """The force's square above the noise, N^2."""
        return float(_total(self.above.sum(), self.power.sum()))

    def factors(self, columns: list[int]) -> np.ndarray:
        """By which the unscaled fields (k,) of these columns make up the force best."""
        found = _solved(self.gram.sum(0), self.pull.sum(0), columns)[0]
        return found / np.where(self.scale[columns] > 0.0, self.scale[columns], 1.0)

    def explained(self, columns: list[int]) -> float:
        """Share of the force above noise."""
        return float(_solved(self.gram.sum(0), self.pull.sum(0), columns)[1]) / self.total

    def drawn(self, columns: list[int]) -> np.ndarray:
        """The same (DRAWS,) of stretches drawn with replacement, the same ones at every call."""
        return _solved(self._draws[0], self._draws[1], columns)[1] / self._draws[2]

    @cached_property
    def _draws(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        count = len(self.power)
        often = np.random.default_rng(SEED).multinomial(count, np.full(count, 1.0 / count), DRAWS).astype(float)
        grams = np.tensordot(often, self.gram, 1)
        return grams, often @ self.pull, _total(often @ self.above, often @ self.power)

    @cached_property
    def _signs(self) -> np.ndarray:
        return np.random.default_rng(SEED).choice([-1.0, 1.0], (FLIPS, len(self.power)))

    def chance(self, known: list[int], ways: list[list[int]]) -> float:
        """How often drawn signs let one of several ways (sets of columns) add as much to what is known as the best of them does: p-value."""
        found = [self._flipped(known, way) for way in ways]
        adds, by_chance = max(one for one, _ in found), np.max([many for _, many in found], axis=0)
        return float((1 + (by_chance >= (1.0 - 1e-9) * adds).sum()) / (1 + FLIPS))

    def _flipped(self, known: list[int], way: list[int]) -> tuple[float, np.ndarray]:
        """What a way adds [N^2], and what with the signs of stretches drawn (FLIPS,)."""
        gram, every = self.gram.sum(0), [*known, *way]
        own = np.zeros((len(self.scale), len(way)))  # the way's fields with the known ones taken out, in terms of all
        own[way, range(len(way))] = 1.0
        left = self.pull[:, every].copy()
        if known:
            ridged = gram[np.ix_(known, known)] + _ridge(gram, known)
            own[known] = -np.linalg.solve(ridged, gram[np.ix_(known, way)])
            left -= self.gram[:, every][:, :, known] @ np.linalg.solve(ridged, self.pull.sum(0)[known])
        scores = left @ own[every]
        inner = own.T @ gram @ own + _ridge(gram, way)
        sums = np.concatenate([scores.sum(0)[None], self._signs @ scores])
        adds = (sums * np.linalg.solve(inner, sums.T).T).sum(1)
        return float(adds[0]), adds[1:]


def _stretches(one: Forces, fields: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, float, int, float]]:
    """Of each stretch of a recording: products of fields, with the force, its square, how many numbers, and the noise's square in each."""
    stretch = ((one.time_s - one.time_s[0]) / STRETCH_S).astype(int)
    for number in np.unique(stretch):
        rows = stretch == number
        x, y = fields[:, rows].reshape(len(fields), -1), one.force_n[rows].ravel()
        yield x @ x.T, x @ y, float(y @ y), y.size, one.floor_n**2


def _total(above: np.ndarray, power: np.ndarray) -> np.ndarray:
    return np.maximum(np.maximum(above, LEAST_ABOVE * power), np.finfo(float).tiny)


def _ridge(gram: np.ndarray, columns: list[int]) -> np.ndarray:
    return RIDGE * np.trace(gram, axis1=-2, axis2=-1)[..., None, None] * np.eye(len(columns))


def _solved(gram: np.ndarray, pull: np.ndarray, columns: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Factors (..., k) and what they explain (...,) [N^2]."""
    right = pull[..., columns]
    inner = gram[..., columns, :][..., columns] + _ridge(gram, columns)
    found = np.linalg.solve(inner, right[..., None])[..., 0]
    return found, (found * right).sum(-1)
