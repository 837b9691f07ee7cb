"""Errors of several networks on the same held-out trajectories, and their resampling: another draw of either may err otherwise."""

import numpy as np
import pandas as pd

from sim1.statistics import Interval

RESAMPLES, TAILS = 2000, (0.025, 0.975)


def error_table(errors: pd.DataFrame, column: str = "joint_error_rad") -> np.ndarray:
    """Errors in a column by trajectory and network (t, s), of one kind of training, size and kind of test.

    Raises:
        ValueError: a network was not tested on each trajectory, or on one twice.
    """
    table = errors.pivot(index=["garment", "trajectory"], columns="seed", values=column)
    if table.isna().any(axis=None):
        place, seed = table.isna().stack().idxmax()[:2], table.columns[table.isna().any()][0]
        raise ValueError(f"no error of the network of seed {seed} on {place}")
    return table.to_numpy()


def interval_of(table: np.ndarray, rng: np.random.Generator) -> Interval | None:
    """95 % interval of the mean of errors (t, s), in their unit; None: there is one trajectory."""
    if len(table) == 1:
        return None
    means = means_of_resamples(table[None], RESAMPLES, rng)[0]
    return Interval(*map(float, np.quantile(means, TAILS)))


def means_of_resamples(tables: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """Means (k, count) of tables (k, t, s), of which trajectories and networks are drawn anew, the same ones in every table.

    Both are samples of all there might be, and cross: each is drawn with replacement, independently (Owen 2007, "The pigeonhole
    bootstrap", Ann. Appl. Stat. 1, 386). Of one trajectory, or one network, the spread among others is not in it.
    """
    _, trajectories, networks = tables.shape
    rows = rng.integers(trajectories, size=(count, trajectories))
    columns = rng.integers(networks, size=(count, networks))
    return tables[:, rows[:, :, None], columns[:, None, :]].mean(axis=(2, 3))
