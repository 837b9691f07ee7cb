"""Two ways of doing the same thing, timed in turns."""

import time
from collections.abc import Callable
from typing import Any


def against(
    what: str, way: Callable[[], Any], other: str, other_way: Callable[[], Any], rounds: int = 3
) -> dict[str, Any]:
    """Least seconds of `way` and of `other_way`, run alternately so that a busy machine hits both, and their ratio."""
    seconds: tuple[list[float], list[float]] = ([], [])
    for _ in range(rounds):
        for taken, do in zip(seconds, (way, other_way), strict=True):
            began = time.perf_counter()
            do()
            taken.append(time.perf_counter() - began)
    best, best_other = min(seconds[0]), min(seconds[1])
    return {
        "what": what,
        "against": other,
        "seconds": round(best, 5),
        "seconds_against": round(best_other, 5),
        "ratio": round(best / best_other, 4),
    }
