"""Where trials took place: in the stand-in reality, or in the simulator that made the training data."""

from collections.abc import Mapping, Sequence

import pandas as pd

REALITY, SIMULATOR = "stand-in reality", "simulator"  # column `world` of the table of trials
_MEANT = {
    REALITY: "the stand-in reality (the simulated cell with a concealed fabric, concealed effects, other friction, finer steps and a finer mesh)",
    SIMULATOR: "the simulator that made the training data, in which nothing is unlike what was learnt from",
}

type Worlds = Mapping[str, Sequence[str]]
"""World -> garments that were driven there."""


def worlds_of(trials: pd.DataFrame) -> dict[str, list[str]]:
    """Of rows of `evaluation.parquet`; empty where no trial was run."""
    return {world: sorted(own["garment"].unique()) for world, own in trials.groupby("world", sort=True)}


def together(worlds: Sequence[Worlds]) -> dict[str, list[str]]:
    """All garments that any of them drove in each world."""
    names = sorted({name for one in worlds for name in one})
    return {name: sorted({garment for one in worlds for garment in one.get(name, ())}) for name in names}


def said_of_worlds(worlds: Worlds) -> list[str]:
    """Sentences of a page; none where no trial was run."""
    said = [
        f"Closed loop in {meant}: {', '.join(worlds[world])}." for world, meant in _MEANT.items() if world in worlds
    ]
    return [*said, "Rates over all garments are of both worlds together."] if len(said) > 1 else said
