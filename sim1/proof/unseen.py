"""Motions that no diagnosis was given, foretold from their start and their drives; how they went is in the answers alone.

The recording that a diagnosis holds out may decide between its models, so that the error there is no test of that choice. These are.
"""

from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from sim1.stage import BadInput

SHORT_S = 0.1  # drives may end by so much before the film
MODELS = ("baseline", "model")  # files of a diagnosis, before and after what was added


def motions_of(bundle: Path) -> list[str]:
    """Names of the recordings in a bundle, those that have markers."""
    return [path.parent.name for path in bundle.glob("recordings/*/markers.parquet")]


def off_mm(foretold: Path, answers: Mapping[str, np.ndarray], motions: Collection[str]) -> float | None:
    """Error of predictions as `sim1 predict` writes them, root mean square per coordinate [mm], from 0 s to the end; None: there are none.

    `answers` holds `NAME/truth_s` (T,) and `NAME/truth_m` (T, M, 3) of each of `motions`, and may of others, without noise, markers in the order
    of their numbers.

    Raises:
        BadInput: the predictions are damaged, or of other motions, instants or markers.
    """
    if not foretold.is_file():
        return None
    try:
        table = pd.read_parquet(foretold)
        return 1e3 * off_m(table, answers, motions)
    except (OSError, ValueError, KeyError, TypeError) as error:  # pyarrow's errors are ValueErrors
        raise BadInput(
            f"{foretold}: no predictions of the motions in the answers ({error}); bring the file that `sim1 predict` wrote"
        ) from error


def off_m(table: pd.DataFrame, answers: Mapping[str, np.ndarray], motions: Collection[str]) -> float:
    """The same of a table with recording, time_s, marker, x_m, y_m, z_m [m].

    Raises:
        KeyError: a column is missing, or the answers tell nothing of a motion.
        ValueError: other motions, instants or markers than theirs, or a place that is not finite.
    """
    squares = []
    if set(table["recording"]) != set(motions):
        raise ValueError(f"foretold are {sorted(set(table['recording'])) or 'none'}, filmed were {sorted(motions)}")
    for name, rows in table.groupby("recording"):
        time_s, truth_m = answers[f"{name}/truth_s"], answers[f"{name}/truth_m"]
        rows = rows.sort_values(["time_s", "marker"])
        instants, count = np.unique(rows["time_s"]), rows["marker"].nunique()
        both = min(len(instants), len(time_s))
        if time_s[-1] - instants[-1] > SHORT_S:
            raise ValueError(f"{name}: foretold until {instants[-1]:.2f} s, filmed until {time_s[-1]:.2f} s")
        if count != truth_m.shape[1] or len(rows) != len(instants) * count or not np.allclose(instants[:both], time_s[:both], atol=1e-6):  # fmt: skip
            raise ValueError(f"{name}: {len(rows)} rows, {len(instants)} instants and {count} markers, the answers have {truth_m.shape[:2]}")  # fmt: skip
        found_m = rows[["x_m", "y_m", "z_m"]].to_numpy().reshape(len(instants), count, 3)
        off = found_m[:both] - truth_m[:both]
        if not np.isfinite(off).all():
            instant, marker, axis = np.argwhere(~np.isfinite(off))[0]
            raise ValueError(f"{name}: {'xyz'[axis]}_m of the marker in place {marker} at {time_s[instant]:.3f} s is {found_m[instant, marker, axis]}, in the answers {truth_m[instant, marker, axis]}")  # fmt: skip
        squares.append(np.square(off).ravel())
    return float(np.sqrt(np.concatenate(squares).mean()))
