"""How long a trial may last: the same for all that are compared, whatever they learnt from."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
from made_up_cell import CONFIG
from made_up_dataset import toy_trajectory, write_dataset, write_demonstrations

from sim1.policy.lessons import GENERATED, REAL, SIMULATED, Lesson
from sim1.policy.stage import policy
from sim1.policy.time_limit import TimeLimit, time_limits


def lasting(garment, frames):
    """A trajectory of so many frames."""
    item = toy_trajectory(garment, "0000", {"0000"}, seed=frames)
    return replace(item, **{name: np.resize(getattr(item, name), (frames, 14)) for name in ("state", "action")})


def lesson(kind, *items, held_out=()):
    return Lesson(kind=kind, train=list(items), orders={}, sizes=[], held_out=list(held_out), splits={})


def test_it_is_by_garment_and_by_real_demonstrations_those_held_out_included():
    real = lesson(REAL, lasting("towel", 50), lasting("polo", 90), held_out=[lasting("towel", 60)])
    others = lesson(GENERATED, lasting("towel", 200), lasting("polo", 20)), lesson(SIMULATED, lasting("polo", 300))
    assert time_limits([*others, real], ["towel", "polo"], factor=1.5, rate_hz=10) == {
        "towel": TimeLimit(duration_s=9.0, longest_of=REAL),
        "polo": TimeLimit(duration_s=13.5, longest_of=REAL),
    }


def test_a_garment_without_them_has_it_by_what_changes_least_between_variants():
    generated = lesson(GENERATED, lasting("towel", 200), lasting("polo", 20), lasting("sock", 30))
    demonstrated = lesson(REAL, lasting("polo", 40)), lesson(SIMULATED, lasting("towel", 100))
    limits = time_limits([generated, *demonstrated], ["towel", "sock"], factor=1.0, rate_hz=10)
    assert limits == {
        "towel": TimeLimit(duration_s=10.0, longest_of=SIMULATED),
        "sock": TimeLimit(duration_s=3.0, longest_of=GENERATED),
    }


def test_variants_that_learn_from_other_trajectories_and_from_no_demonstration_allow_the_same(
    tmp_path, bench, trajectories
):
    towels = [item for item in trajectories if item.garment == "towel"]
    arrays = ("state", "action", "keypoints")
    slower = [replace(item, **{name: np.repeat(getattr(item, name), 2, axis=0) for name in arrays}) for item in towels]
    demos = {"towel": write_demonstrations(tmp_path / "demos", towels)}
    config = replace(CONFIG, sizes=(2,), seeds=(0,), steps=10, trial_count=1, shifts=("spatial",))
    limits, lasted = [], set()
    for name, made, sizes in (("base", towels, (1,)), ("variant", slower, ())):
        dataset, out = write_dataset(tmp_path / f"{name} data", made), tmp_path / name
        out.mkdir()
        own = replace(config, simulated_sizes=sizes, real_sizes=sizes)
        policy({"dataset": {"": dataset.path}, "real_demos": demos, "seed_demos": demos}, out, own)
        limits.append(json.loads((out / "policy.json").read_text())["trials"]["time_limits"])
        lasted |= set(pd.read_parquet(out / "evaluation.parquet")["simulated_s"])
    assert limits == 2 * [{"towel": {"duration_s": 4.8, "longest_of": REAL}}]  # 1.2 times 40 frames at 10 Hz
    assert lasted == {4.8}
