import pytest
from validity_synthetic import TINY, make_artifacts, run

from sim1.validity.stage import StateRulesConfig, state_rules, video_discriminator


@pytest.fixture(scope="session")
def world(tmp_path_factory):
    """Three good demonstrations, four good candidates and one that folded half-way."""
    root = tmp_path_factory.mktemp("validity")
    inputs = make_artifacts(root, [1.0, 0.98, 0.99], [1.0, 0.97, 0.99, 0.96, 0.45])
    run(state_rules, inputs, root / "state_rules", StateRulesConfig())
    inputs["state_rules"] = {"sheet": root / "state_rules"}
    run(video_discriminator, inputs, root / "video_discriminator", TINY)
    inputs["video_discriminator"] = {"sheet": root / "video_discriminator"}
    return root, inputs
