"""Pictures of a diagnosis."""

from dataclasses import replace
from types import SimpleNamespace

import matplotlib.image
import numpy as np
import pytest
from small_bundle import empty_bundle

from sim1.mismatch.finding_pictures import draw_key_frames

HELD = "swing_0"


@pytest.fixture
def height(tmp_path):
    """Pixels by which moments are high of the first recording's markers, stretched in height."""

    def drawn(stretch: float) -> int:
        bundle = empty_bundle(count=4, motions=1)
        stretched = bundle.recordings[0].markers_m * np.array([1.0, 1.0, stretch])
        recording = replace(bundle.recordings[0], markers_m=stretched)
        runs = {label: {HELD: stretched + 1e-3} for label in ("baseline", "augmented")}
        found = SimpleNamespace(heldout=(HELD,), heldout_markers_m=runs)
        draw_key_frames(tmp_path / "moments.png", replace(bundle, recordings=(recording,)), found)
        return matplotlib.image.imread(tmp_path / "moments.png").shape[0]

    return drawn


def test_moments_are_drawn_as_high_as_the_cloth_hangs(height):
    shallow, square, deep = (height(stretch) for stretch in (0.25, 1.0, 4.0))
    assert shallow < 0.75 * square
    assert 1.2 * square < deep < 1.7 * square  # no higher than a screen
