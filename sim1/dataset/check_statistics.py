"""Stored statistics of a LeRobot v3 dataset, of the whole and of every episode, against what the data say."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from sim1.dataset.check_images import channels_of
from sim1.dataset.tables import EPISODES, STATS, TEXT, VISUAL, Tables, column, plain
from sim1.stage import Finding

BASIC = ("min", "max", "mean", "std")
ROUNDING = float(np.finfo(np.float32).eps)
# LeRobot's own merge and split renumber frames, episodes and tasks and leave their statistics as they were; nothing is
# normalised with them.
RENUMBERED = ("index", "episode_index", "task_index")
AGGREGATED = 1e-5  # of pictures' values in 0..1: how far the whole may be from its episodes put together


def check_statistics(tables: Tables) -> Finding:
    """Finding `statistics_true`: what policies are normalised with is true of the data.

    Numbers: min, max, mean, std and count are those of the frames, but for the numbering; quantiles lie in order between min
    and max. Pictures: LeRobot takes a sample before encoding, so their statistics cannot be computed again from the videos;
    they have the right shape and range, and the whole is its episodes put together.
    """
    from sim1.dataset.check import finding

    faults, count = [], 0
    for name, feature in tables.info["features"].items():
        if feature["dtype"] in TEXT:
            continue
        count += 1
        if name not in tables.stats:
            faults.append(f"{STATS}: no {name}")
            continue
        check = _visual if feature["dtype"] in VISUAL else _numeric
        faults += check(name, feature, tables)
    return finding("statistics_true", faults, f"{count} features, whole and by episode")


def _numeric(name: str, feature: dict[str, Any], tables: Tables) -> Iterator[str]:
    values = column(tables.frames, name).astype(float).reshape(len(tables.frames), -1, feature["shape"][-1])
    longest = int(tables.episodes["length"].max()) if len(tables.episodes) else 0
    yield from _compared(f"{STATS}: {name}", tables.stats[name], values, longest, name)
    starts = np.cumsum([0, *tables.episodes["length"]])
    for row, index in enumerate(tables.episodes["episode_index"]):
        part = values[starts[row] : starts[row + 1]]
        yield from _compared(
            f"{EPISODES}: episode {index}: {name}", _of_episode(tables, row, name), part, len(part), name
        )


def _compared(where: str, said: dict[str, Any], values: np.ndarray, longest: int, name: str) -> Iterator[str]:
    """Faults of the statistics of `values` (n, ..., c), which were summed in float32 over up to `longest` frames."""
    numbers, faults = _numbers(where, said, (values.shape[-1],))
    yield from faults
    if faults or not len(values):
        return
    if int(numbers["count"][0]) != len(values):
        yield f"{where}: count is {numbers['count'][0]:g}, of {len(values)} frames"
    if name in RENUMBERED:
        return
    flat = values.reshape(-1, values.shape[-1])
    square = (flat**2).mean(axis=0)
    # A naive sum in float32 is off by up to eps a term, and LeRobot takes the variance as E[x²] - E[x]².
    sums = ROUNDING * max(longest, 16)
    true = {"min": flat.min(axis=0), "max": flat.max(axis=0), "mean": flat.mean(axis=0), "std": flat.std(axis=0)}
    ends = {key: 4 * ROUNDING * np.abs(true[key]) for key in ("min", "max")}
    off = {key: np.abs(numbers[key] - true[key]) - ends[key] for key in ends}
    off["mean"] = np.abs(numbers["mean"] - true["mean"]) - sums * np.sqrt(square)
    off["std"] = np.where(
        numbers["std"] < 0, np.inf, np.abs(numbers["std"] ** 2 - true["std"] ** 2) - 2 * sums * square
    )
    for key in BASIC:
        if (wrong := np.flatnonzero(~(off[key] <= 1e-9))).size:  # NaN as well
            at = wrong[0]
            yield f"{where}: {key}[{at}] is {numbers[key][at]:.6g}, the data have {true[key][at]:.6g}"
    yield from _unordered(where, numbers)


def _visual(name: str, feature: dict[str, Any], tables: Tables) -> Iterator[str]:
    channels = channels_of(feature)
    top = np.inf if (feature.get("info") or {}).get("is_depth_map") else 1.0
    whole, faults = _numbers(f"{STATS}: {name}", tables.stats[name], (channels, 1, 1))
    parts = []
    for row, index in enumerate(tables.episodes["episode_index"]):
        part, wrong = _numbers(f"{EPISODES}: episode {index}: {name}", _of_episode(tables, row, name), (channels, 1, 1))
        parts.append(part)
        faults += wrong or _out_of_range(f"{EPISODES}: episode {index}: {name}", part, top)
    yield from faults
    if faults or not parts:
        return
    yield from _out_of_range(f"{STATS}: {name}", whole, top)
    stacked = {key: np.stack([part[key] for part in parts]) for key in (*BASIC, "count")}
    weights = (stacked["count"] / stacked["count"].sum()).reshape(-1, 1, 1, 1)
    mean = (weights * stacked["mean"]).sum(axis=0)
    variance = (weights * (stacked["std"] ** 2 + (stacked["mean"] - mean) ** 2)).sum(axis=0)
    true = {
        "min": stacked["min"].min(axis=0),
        "max": stacked["max"].max(axis=0),
        "mean": mean,
        "std": np.sqrt(variance),
        "count": stacked["count"].sum(axis=0),
    }
    for key, value in true.items():
        if not np.allclose(whole[key], value, rtol=AGGREGATED, atol=AGGREGATED):
            yield f"{STATS}: {name}: {key} is {_short(whole[key])}, its episodes together have {_short(value)}"


def _out_of_range(where: str, numbers: dict[str, np.ndarray], top: float) -> list[str]:
    faults = []
    if (numbers["min"] < 0).any() or (numbers["max"] > top + ROUNDING).any():
        faults.append(
            f"{where}: from {numbers['min'].min():.4g} to {numbers['max'].max():.4g}, expected within 0 to {top:g}"
        )
    spread = (numbers["max"] - numbers["min"]) / 2  # no std is larger
    if (numbers["std"] < 0).any() or (numbers["std"] > spread + AGGREGATED).any():
        faults.append(f"{where}: std is {_short(numbers['std'])}, no values from min to max have that")
    if numbers["count"][0] < 1:
        faults.append(f"{where}: count is {numbers['count'][0]:g}")
    outside = (numbers["mean"] < numbers["min"] - AGGREGATED) | (numbers["mean"] > numbers["max"] + AGGREGATED)
    if outside.any():
        faults.append(f"{where}: mean is {_short(numbers['mean'])}, not between min and max")
    return faults + list(_unordered(where, numbers))


def _unordered(where: str, numbers: dict[str, np.ndarray]) -> Iterator[str]:
    """Quantiles lie in order between min and max."""
    keys = ["min", *sorted(key for key in numbers if _is_quantile(key)), "max"]
    for low, high in pairwise(keys):
        if not (numbers[low] <= numbers[high] + 1e-6 * (1 + np.abs(numbers[high]))).all():
            yield f"{where}: {low} is {_short(numbers[low])}, above {high} {_short(numbers[high])}"


def _of_episode(tables: Tables, row: int, name: str) -> dict[str, Any]:
    start = f"stats/{name}/"
    return {
        key[len(start) :]: tables.episode_stats[key].iloc[row] for key in tables.episode_stats if key.startswith(start)
    }


def _numbers(where: str, said: dict[str, Any], shape: tuple[int, ...]) -> tuple[dict[str, np.ndarray], list[str]]:
    """Statistics as arrays of that shape, a count of one number; and what is wrong with them as such."""
    numbers, faults = {}, []
    for key in (*BASIC, "count", *filter(_is_quantile, said)):
        if key not in said:
            faults.append(f"{where}: no {key}")
            continue
        try:
            numbers[key] = np.atleast_1d(np.array(plain(said[key]), float))
        except (ValueError, TypeError):
            faults.append(f"{where}: {key} is {said[key]!r:.80}, not numbers")
            continue
        wanted = (1,) if key == "count" else shape
        if numbers[key].shape != wanted:
            faults.append(f"{where}: {key} has shape {numbers[key].shape}, expected {wanted}")
        elif not np.isfinite(numbers[key]).all():
            faults.append(f"{where}: {key} is {_short(numbers[key])}")
    return numbers, faults


def _is_quantile(key: str) -> bool:
    return key[:1] == "q" and key[1:].isdigit()


def _short(values: np.ndarray) -> str:
    text = ", ".join(f"{value:.4g}" for value in values.ravel()[:4])
    return text if values.size <= 4 else f"{text}, ..."
