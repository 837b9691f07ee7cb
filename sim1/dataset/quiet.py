"""Keeps the libraries behind LeRobot from talking over the pipeline's own progress."""

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def quiet_libraries() -> Iterator[None]:
    """Silence the video encoder and the progress bars of `datasets` inside the block; errors are still told."""
    import av.logging
    import datasets

    bars = datasets.are_progress_bars_disabled()
    datasets.disable_progress_bars()
    av.logging.set_libav_level(av.logging.ERROR)
    try:
        yield
    finally:
        av.logging.set_libav_level(av.logging.INFO)  # FFmpeg's own default
        if not bars:
            datasets.enable_progress_bars()
