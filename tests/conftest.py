"""Both cores are taken by test processes: within one of them, libraries use one thread, and what takes longest begins first."""

import os

import pytest

LONGEST = (  # files that take a minute or so: the last of them would else keep one process busy alone
    "test_pipeline_smoke.py",
    "test_graph_regeneration.py",  # without the identification simulator, whose loops the first one compiles meanwhile
    "test_graph_of_the_project.py",
    "test_mismatch_diagnosis.py",
    "test_mismatch_smooth_push.py",
    "test_mismatch_stage.py",
    "test_image_policy_training.py",
    "test_mismatch_simulator.py",
    "test_pipeline_bad_input.py",
    "test_image_policy_stage.py",
    "test_policy_real_parts.py",
)

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Longest first, all others in their order."""
    ranks = {name: rank for rank, name in enumerate(LONGEST)}
    items.sort(key=lambda item: ranks.get(item.path.name, len(ranks)))
