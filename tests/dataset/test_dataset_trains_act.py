"""The dataset is one that LeRobot's own policies learn from: ACT, twenty episodes, a hundred steps."""

import numpy as np
import pytest
from rendered_towel import ROBOT, write_rendered

from sim1.dataset.stage import NAME, DatasetConfig, dataset

EPISODES, STEPS = 20, 100


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # of torch and torchvision, not of this project
def test_act_learns_in_a_hundred_steps_from_twenty_episodes_that_lerobot_reads(tmp_path):
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    from sim1.policy.image.build import load, policy_config, save
    from sim1.policy.image.frames import open_frames, read_features, training_statistics
    from sim1.policy.image.policy_file import PolicyFile
    from sim1.policy.image.training import TrainingPlan, train

    data = tmp_path / "dataset"
    data.mkdir()
    counts = tuple(19 + 3 * (number % 4) for number in range(EPISODES))
    rendered = write_rendered(tmp_path / "towel", frame_counts=counts)
    dataset({"robot": ROBOT, "rendered_episodes": {"towel": rendered}}, data, DatasetConfig())
    read = LeRobotDataset(NAME, root=data / "lerobot", video_backend="pyav")
    assert read.num_episodes == EPISODES

    settings = {"pretrained_backbone_weights": None, "dim_model": 64, "n_heads": 4, "dim_feedforward": 128}
    small = {"n_encoder_layers": 1, "use_vae": False, "optimizer_lr": 1e-3, "optimizer_lr_backbone": 1e-5}
    file = PolicyFile(title="ACT", type="act", settings={**settings, **small})
    features = read_features(data)
    config = policy_config(tmp_path / "act.yaml", file, "tiny", features=features, chunk_frames=5, device="cpu")
    episodes = list(range(EPISODES))
    plan = TrainingPlan(steps=STEPS, batch=8, seed=0)
    statistics = training_statistics(data, episodes)
    trained, losses = train(data, episodes, config, None, (), statistics, plan, tmp_path / "training")
    assert len(losses) == STEPS
    assert np.mean(losses[-10:]) < 0.5 * np.mean(losses[:10])

    # What lerobot loads again says what was taught: postures differ by 0.35 rad on average.
    save(tmp_path / "policy", trained)
    again = load(tmp_path / "policy", "cpu")
    frames = open_frames(data, [0], config)
    item = {name: value[None] if hasattr(value, "shape") else [value] for name, value in frames[0].items()}
    said = again.restore(again.policy.predict_action_chunk(again.prepare(item)))
    assert said.shape == (1, 5, 14)
    assert float((said - item["action"]).abs().mean()) < 0.2
