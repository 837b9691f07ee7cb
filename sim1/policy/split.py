"""Which trajectories train a policy and which are kept to test it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from sim1.dataset.reshape import kindred
from sim1.policy.episodes import Trajectory
from sim1.stage import random_stream


@dataclass(frozen=True, kw_only=True)
class GarmentSplit:
    """Trajectories of one garment."""

    train: list[Trajectory]
    test: list[Trajectory]
    kind: Literal["source", "trajectory", "none"]  # what the test trajectories do not share with training
    held_out_sources: tuple[str, ...]  # the demonstrations that no training trajectory uses

    def as_row(self, garment: str) -> dict[str, object]:
        """A row of a report's table."""
        return {
            "garment": garment,
            "train": len(self.train),
            "held out": len(self.test),
            "split": self.kind,
            "held-out sources": list(self.held_out_sources),
        }

    def sources_of_tests(self) -> dict[str, str]:
        """Name of each test trajectory -> the held-out demonstrations that it uses, with those linked to these.

        Trajectories of one value hang together. Of kind "trajectory" none is held out: all that they use count.
        """
        used = [item.sources & set(self.held_out_sources) or item.sources for item in self.test]
        groups = kindred([sorted(sources) for sources in used])
        found = {}
        for item, group in zip(self.test, groups, strict=True):
            linked = set().union(*(used[place] for place in np.flatnonzero(groups == group)))
            found[item.name] = " + ".join(sorted(linked)) or item.name  # one that names none is kin to none
        return found


def split_garment(trajectories: Sequence[Trajectory], test_share: float, rng: np.random.Generator) -> GarmentSplit:
    """Hold out every trajectory that uses one of some source demonstrations.

    Generated motion mixes segments of several demonstrations, so test trajectories may share other sources with training; no
    interaction of the held-out ones is in training, but the motion model that joins all of them, and the filters that let them pass,
    may have learnt from any. There are as many of these as bring the share of the trajectories near to `test_share`. Where no source
    leaves both sides filled, single trajectories are held out (kind "trajectory"); a lone trajectory trains and nothing is tested
    (kind "none").
    """
    if len(trajectories) < 2:
        return GarmentSplit(train=list(trajectories), test=[], kind="none", held_out_sources=())
    if held_out := _sources_to_hold_out(trajectories, test_share):
        test = [item for item in trajectories if not item.sources.isdisjoint(held_out)]
        train = [item for item in trajectories if item.sources.isdisjoint(held_out)]
        return GarmentSplit(train=train, test=test, kind="source", held_out_sources=tuple(held_out))
    count = min(max(1, round(test_share * len(trajectories))), len(trajectories) - 1)
    chosen = set(rng.permutation(len(trajectories))[:count].tolist())
    return GarmentSplit(
        train=[item for place, item in enumerate(trajectories) if place not in chosen],
        test=[item for place, item in enumerate(trajectories) if place in chosen],
        kind="trajectory",
        held_out_sources=(),
    )


def _sources_to_hold_out(trajectories: Sequence[Trajectory], test_share: float) -> list[str]:
    """The source that by itself comes nearest to the share, then others one by one, while the next comes nearer; names sorted.

    Of equally near ones the first by name. Something is left to train on: sources without which nothing would be are not taken, and
    where that is every one, there is none.
    """
    sources = sorted(set().union(*(item.sources for item in trajectories)))
    uses = np.array([[source in item.sources for source in sources] for item in trajectories], dtype=bool)
    wanted = test_share * len(trajectories)
    held, chosen, off = np.zeros(len(trajectories), dtype=bool), [], np.inf
    while sources:
        counts = (uses | held[:, None]).sum(axis=0)
        offs = np.where(counts < len(trajectories), np.abs(counts - wanted), np.inf)
        best = int(offs.argmin())
        if offs[best] >= off:  # those that are taken change nothing and are no nearer
            break
        chosen, held, off = [*chosen, sources[best]], held | uses[:, best], offs[best]
    return sorted(chosen)


def split_by_garment(trajectories: Sequence[Trajectory], test_share: float, seed: int) -> dict[str, GarmentSplit]:
    """Each garment's split, names sorted: the same seed and share hold out the same, whichever stage asks."""
    names = sorted({item.garment for item in trajectories})
    own = {name: [item for item in trajectories if item.garment == name] for name in names}
    return {name: split_garment(own[name], test_share, random_stream(seed, "split", name)) for name in names}


def sources_of_tests(splits: Mapping[str, GarmentSplit]) -> dict[tuple[str, str], str]:
    """Garment and name of each test trajectory -> its held-out demonstrations, see `GarmentSplit.sources_of_tests`."""
    return {
        (garment, name): source
        for garment, split in splits.items()
        for name, source in split.sources_of_tests().items()
    }


def nested_order(trajectories: Sequence[Trajectory], rng: np.random.Generator) -> list[Trajectory]:
    """Random order in which the garments take turns, while they last: larger prefixes hold smaller ones.

    A prefix that has as many trajectories as there are garments, or more, shows all of them; a smaller one does not.
    """
    queues: dict[str, list[Trajectory]] = {}
    for item in trajectories:
        queues.setdefault(item.garment, []).append(item)
    shuffled = [[queues[name][place] for place in rng.permutation(len(queues[name]))] for name in sorted(queues)]
    return [
        queue[turn] for turn in range(max(map(len, shuffled), default=0)) for queue in shuffled if turn < len(queue)
    ]


def usable_sizes(requested: Sequence[int], available: int, garment_count: int = 1) -> list[int]:
    """Requested training sizes; those beyond what is available become one size, all that is available.

    A size that this one exceeds by less than a quarter is left out: its point would say the same. Sizes below the number of
    garments become that number: a policy is tested on all garments, and what it was not shown says nothing of its size.
    """
    wanted = {max(size, garment_count) for size in requested if size > 0}
    sizes = {size for size in wanted if size <= available}
    if available > 0 and max(wanted, default=0) > available:
        sizes = {size for size in sizes if size * 1.25 <= available} | {available}
    return sorted(sizes)
