"""Which of several states a force depends on: taken in one by one, the largest share first, each beyond those before.

A state counts where it explains a tenth of the force beyond the others, and drawn signs let it do so in one of a hundred cases; it is
ruled out where it explains less than that tenth in 95 of 100 draws of stretches. Where another one in its place does as well in 5 of 100
draws, to a fiftieth of what it explains, neither is told from the other.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from sim1.mismatch.shares import Shares

LEAST = 0.1  # share of the force that is called a dependence
LEVEL = 0.01  # of the test against chance, by state
TAIL = 0.05  # of draws
ALIKE = 0.02  # of what is explained: more fields always explain a trifle more

type Ways = dict[str, list[list[int]]]
"""By state: columns of each of the ways in which a force may follow it."""
type Answer = Literal["yes", "no", "undecided"]


@dataclass(frozen=True, kw_only=True)
class Dependence:
    """What is known of one state."""

    share: float  # of the force's square above noise, beyond the other states that it follows
    answer: Answer
    way: int  # of the state's ways, the one that explains most
    told: bool  # whether it does so in 95 of 100 draws, by a fiftieth of what it explains
    taken: bool  # whether it is among those that the force is explained by
    twin: str | None = None  # a state that it is not told from


def dependences(shares: Shares, ways: Ways, known: list[int]) -> dict[str, Dependence]:
    """By state; `known` columns are taken out beforehand."""
    choice = _Choice(shares, ways, known)
    untried = list(ways)
    while found := choice.next(untried):
        untried.remove(found)
        choice.take(found)
    twins = choice.twins()
    return {state: choice.of(state, twins.get(state)) for state in ways}


class _Choice:
    """States that are taken, each in one of its ways."""

    def __init__(self, shares: Shares, ways: Ways, known: list[int]):
        self._shares, self._ways, self._known = shares, ways, known
        self._taken: dict[str, int] = {}

    def next(self, states: list[str]) -> str | None:
        """The state that adds most, of those that chance does not explain; None: there is none."""
        adds = {state: self._added(state) for state in states}
        for state in sorted(adds, key=lambda state: -adds[state]):
            if adds[state] >= LEAST and self._shares.chance(self._columns(), self._ways[state]) <= LEVEL:
                return state
        return None

    def take(self, state: str) -> None:
        """Take a state in, and leave those out that add nothing to it."""
        self._taken[state] = self._best(state)
        for one in self._taken:
            self._taken[one] = self._best(one)
        for one in list(self._taken):
            if self._added(one) < LEAST:
                del self._taken[one]

    def twins(self) -> dict[str, str]:
        """States of which one could stand for the other."""
        whole, found = self._shares.drawn(self._columns()), dict[str, str]()
        for one in self._taken:
            others = self._columns(but=one)
            alike = ALIKE * (whole - self._shares.drawn(others))
            for state in (state for state in self._ways if state not in self._taken):
                if np.quantile(whole - self._drawn(state, others).max(0) - alike, TAIL) <= 0.0:
                    found.setdefault(state, one)
                    found.setdefault(one, state)
        return found

    def of(self, state: str, twin: str | None) -> Dependence:
        """What is known of a state."""
        others, way = self._columns(but=state), self._best(state)
        drawn = self._drawn(state, others)
        before = self._shares.drawn(others)
        most = drawn.max(0) - before
        answer: Answer = "undecided"
        if twin is None and state in self._taken:
            answer = "yes"
        elif twin is None and np.quantile(most, 1.0 - TAIL) < LEAST:
            answer = "no"
        return Dependence(
            share=min(max(self._added(state), 0.0), 1.0),
            answer=answer,
            way=way,
            told=len(drawn) == 1
            or float(np.quantile((1.0 - ALIKE) * most - np.delete(drawn, way, 0).max(0) + before, TAIL)) > 0.0,
            taken=state in self._taken,
            twin=twin,
        )

    def _columns(self, but: str = "") -> list[int]:
        taken = (self._ways[state][way] for state, way in self._taken.items() if state != but)
        return [*self._known, *(column for own in taken for column in own)]

    def _best(self, state: str) -> int:
        others = self._columns(but=state)
        return int(np.argmax([self._shares.explained([*others, *way]) for way in self._ways[state]]))

    def _added(self, state: str) -> float:
        others = self._columns(but=state)
        own = [*others, *self._ways[state][self._best(state)]]
        return self._shares.explained(own) - self._shares.explained(others)

    def _drawn(self, state: str, others: list[int]) -> np.ndarray:
        """By way of a state (W, DRAWS), what it and the others explain."""
        return np.array([self._shares.drawn([*others, *way]) for way in self._ways[state]])
