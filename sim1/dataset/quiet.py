"""Keeps the libraries behind LeRobot from talking over the pipeline's own progress."""

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def quiet_libraries() -> Iterator[None]:
    """Silence the video encoder, LeRobot's warnings and the progress bars of `datasets` inside the block; errors are still told."""
    import logging

    import av.logging
    import datasets

    lerobot = logging.getLogger("lerobot")
    level = lerobot.level
    bars = datasets.are_progress_bars_disabled()
    datasets.disable_progress_bars()
    av.logging.set_libav_level(av.logging.ERROR)
    lerobot.setLevel(logging.ERROR)  # without a fitting FFmpeg it tells at length that it decodes with PyAV, as asked
    try:
        yield
    finally:
        lerobot.setLevel(level)
        av.logging.set_libav_level(av.logging.INFO)  # FFmpeg's own default
        if not bars:
            datasets.enable_progress_bars()
