"""Strict reading of the NPZ files that stages write."""

from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from sim1.stage import BadInput

type Shape = tuple[int | str, ...]
"""Length of each dimension; a name stands for a length that all shapes of one file share under it."""

AGAIN = "make it again"


def read_arrays(path: Path, names: Iterable[str], what: str = "NPZ file", remedy: str = AGAIN) -> dict[str, np.ndarray]:
    """Arrays of an NPZ file, at least `names` of them.

    Raises:
        BadInput: the file is missing or damaged, or lacks an array; says which array, and what to do.
    """
    arrays: dict[str, np.ndarray] = {}
    place = ""
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            for name in archive.files:
                place = f"array {name!r}: "
                arrays[name] = archive[name]
    except FileNotFoundError as error:
        raise BadInput(f"{path}: not a readable {what} (missing); {remedy}") from error
    except Exception as error:  # zipfile, zlib and numpy raise many kinds of errors on damaged files
        said = " ".join(str(error).split())[:160] or type(error).__name__
        raise BadInput(f"{path}: damaged, not a readable {what} ({place}{said}); {remedy}") from error
    _require(arrays, path, names, what, remedy)
    return arrays


def read_numbers(path: Path, shapes: Mapping[str, Shape], what: str = "NPZ file", remedy: str = AGAIN) -> dict[str, np.ndarray]:  # fmt: skip
    """The arrays that `shapes` names, each of that shape, all numbers and finite.

    Raises:
        BadInput: as `read_arrays`, or an array is of another kind or shape, or holds a value that is not finite.
    """
    return numbers_of(read_arrays(path, (), what, remedy), path, shapes, what, remedy)


def numbers_of(
    arrays: Mapping[str, np.ndarray],
    path: Path,
    shapes: Mapping[str, Shape],
    what: str = "NPZ file",
    remedy: str = AGAIN,
) -> dict[str, np.ndarray]:
    """The same of arrays that were read from `path`.

    Raises:
        BadInput: an array is missing, of another kind or shape, or holds a value that is not finite.
    """
    _require(arrays, path, shapes, what, remedy)
    lengths: dict[int | str, int] = {}
    for name, shape in shapes.items():
        array = arrays[name]
        if array.dtype.kind not in "fiu":
            raise BadInput(f"{path}: array {name!r} holds {array.dtype}, expected numbers; {remedy}")
        if array.ndim == len(shape):
            lengths = dict(zip(shape, array.shape, strict=True)) | lengths  # the first one of a name sets it
        wanted = tuple(lengths.get(part, part) if isinstance(part, str) else part for part in shape)
        if array.shape != wanted:
            raise BadInput(f"{path}: array {name!r} is {array.shape}, expected {wanted}; {remedy}")
        if not np.isfinite(array).all():
            where = tuple(int(index) for index in np.argwhere(~np.isfinite(array))[0])
            raise BadInput(f"{path}: array {name!r} is {array[where]} at {where}, expected finite numbers; {remedy}")
    return {name: arrays[name] for name in shapes}


def _require(arrays: Mapping[str, np.ndarray], path: Path, names: Iterable[str], what: str, remedy: str) -> None:
    if missing := [name for name in names if name not in arrays]:
        raise BadInput(f"{path}: not a readable {what} (no array {missing[0]!r}, only {sorted(arrays)}); {remedy}")
