"""Trials with a painted camera over a cell that cannot fail."""

from pathlib import Path

import numpy as np
from made_up_cell import ObedientCell, start

from sim1.policy.trials import Bench
from sim1.policy.worlds import REALITY


class PaintedCamera:
    """In place of the live camera: a picture tells the look's fabric, and the frame's number."""

    def __init__(self, film_set, config, folder):
        assert Path(folder).is_dir()
        self.size = config.height, config.width

    def show(self, clip):
        self.clip = clip

    def pictures(self, *, garment_m, joints_rad, openness, frame):
        image = np.full((*self.size, 3), 255 * np.array(self.clip.appearance.fabric.colors[0])).astype(np.uint8)
        image[:, frame : frame + 2] = 255
        return {"head": image}

    def close(self):
        pass


def bench(factor: float, breaks_at: int | None = None) -> Bench:
    """Folds where friction is as it is, and says so."""

    def judge(history):
        return factor == 1.0, None if factor == 1.0 else "slip", {"factor": factor}

    def look(garment_m):
        raise AssertionError("a policy that sees pictures is shown by what it saw")

    return Bench(world=REALITY, cell=ObedientCell(breaks_at), start=start(), judge=judge, look=look)
