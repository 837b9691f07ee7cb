"""A cell that cannot fail in place of the simulated one, and a small experiment in it."""

from dataclasses import dataclass, field

import numpy as np

from sim1.cloth.cell import SimulationBroke
from sim1.policy.rollout import Start
from sim1.policy.stage import PolicyConfig
from sim1.policy.trials import Bench
from sim1.policy.worlds import SIMULATOR

VERTICES = 12
CONFIG = PolicyConfig(
    sizes=(2, 4, 99),
    simulated_sizes=(),
    seeds=(0, 1),
    steps=60,
    batch=32,
    width=32,
    depth=2,
    chunk_s=0.5,
    replan_s=0.2,
    trial_count=2,
    evaluate_garment_count=2,
    shifts=("in-domain", "spatial"),
    processes=1,
)


@dataclass
class ObedientCell:
    """Arms are where they are told to be, the garment stays; it may break at a frame."""

    breaks_at: int | None = None
    frame: int = 0
    commands: list = field(default_factory=list)

    def reset(self, garment_m, joints_rad, openness):
        self.garment_m, self.joints_rad, self.openness, self.frame = garment_m, joints_rad, openness, 0

    def step(self, joints_rad, openness):
        self.joints_rad, self.openness = np.array(joints_rad), np.array(openness)
        self.commands.append(np.concatenate([joints_rad, openness[:, None]], axis=1).ravel())
        self.frame += 1
        if self.frame == self.breaks_at:
            raise SimulationBroke(self.frame, 0, "vertex 0 is lost")


def start() -> Start:
    garment = np.random.default_rng(0).uniform(-0.1, 0.1, (VERTICES, 3))
    return Start(garment_m=garment, joints_rad=np.zeros((2, 6)), openness=np.ones(2))


def look(garment_m):
    assert garment_m.shape == (VERTICES, 3)
    return np.zeros((12, 16, 3), np.uint8)


def idle_bench() -> Bench:
    """A garment that nobody ever folds."""

    def judge(history):
        return False, "not_folded", {"frames": len(history)}

    return Bench(world=SIMULATOR, cell=ObedientCell(), start=start(), judge=judge, look=look)


def failed(findings):
    return [finding.name for finding in findings if not finding.passed and finding.blocking]
