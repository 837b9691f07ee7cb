"""Settings at the edge of what they may be: of the motion model, and of how many attempts are made."""

import json

import numpy as np
import pytest
from motion_synthetic import a_demo
from pydantic import ValidationError

from sim1.motion.generation import quotas_of
from sim1.motion.model import read_model, transition
from sim1.motion.pool import write_pool
from sim1.motion.stage import CandidateTrajectoriesConfig, MotionModelConfig, motion_model
from sim1.motion.transitions import transitions_of


def test_a_model_of_fewer_examples_than_shapes_can_be_read_again(tmp_path):
    rng = np.random.default_rng(5)
    pool = [part for index in range(2) for part in a_demo(f"{index:04d}", rng, 3 * index)]
    for name in ("pool", "out"):
        (tmp_path / name).mkdir()
    write_pool(tmp_path / "pool", pool)
    config = MotionModelConfig(step_count=11, bank_count=64, shape_count=128, width=16, layer_count=1)
    motion_model({"segment_pool": {"sheet": tmp_path / "pool"}}, tmp_path / "out", config)
    assert json.loads((tmp_path / "out" / "model.json").read_text())["shape_count"] == 64
    model, item = read_model(tmp_path / "out"), transitions_of(pool)[0]
    made = transition(model, item.history, item.after, 20, rng)
    assert np.isfinite(made.position_m).all()


def test_a_training_too_short_to_warm_up_is_refused_as_a_setting():
    with pytest.raises(ValidationError, match="greater than or equal to 11"):
        MotionModelConfig(step_count=10)


def test_draws_out_of_reach_do_not_keep_from_as_many_runs_as_are_allowed():
    config = CandidateTrajectoriesConfig(candidate_count=1, success_target=1, run_limit=20, tries_per_candidate=2)
    meant, _ = quotas_of(config, "towel")
    missed = {"ran": False, "success": False}
    ran = {"ran": True, "success": False}
    assert meant.wants_more([ran] * 19 + [missed] * 19)
    assert not meant.wants_more([ran] * 20)
    assert not meant.wants_more([missed] * 40)
