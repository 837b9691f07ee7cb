"""The dataset is one that LeRobot's own policies learn from."""

import pytest
from rendered_towel import write_rendered

from sim1.dataset.stage import DatasetConfig, dataset


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # of torch and torchvision, not of this project
def test_act_learns_from_the_dataset(tmp_path):
    import torch
    from lerobot.configs.types import FeatureType
    from lerobot.datasets.lerobot_dataset import LeRobotDataset
    from lerobot.policies.act.configuration_act import ACTConfig
    from lerobot.policies.act.modeling_act import ACTPolicy
    from lerobot.policies.act.processor_act import make_act_pre_post_processors
    from lerobot.utils.feature_utils import dataset_to_policy_features

    (tmp_path / "out").mkdir()
    dataset({"rendered_episodes": {"towel": write_rendered(tmp_path / "towel")}}, tmp_path / "out", DatasetConfig())
    chunk = 4
    root = tmp_path / "out" / "lerobot"
    steps = {"action": [frame / 10 for frame in range(chunk)]}
    data = LeRobotDataset("sim1/folding", root=root, video_backend="pyav", delta_timestamps=steps)
    features = dataset_to_policy_features(data.meta.features)
    torch.manual_seed(0)
    config = ACTConfig(
        input_features={name: item for name, item in features.items() if item.type is not FeatureType.ACTION},
        output_features={name: item for name, item in features.items() if item.type is FeatureType.ACTION},
        chunk_size=chunk,
        n_action_steps=chunk,
        dim_model=32,
        n_heads=2,
        dim_feedforward=64,
        n_encoder_layers=1,
        use_vae=False,
        pretrained_backbone_weights=None,  # no download
        device="cpu",
    )
    policy = ACTPolicy(config)
    prepare, _ = make_act_pre_post_processors(config, dataset_stats=data.meta.stats)
    optimizer = torch.optim.Adam(policy.parameters(), lr=1e-3)
    batch = prepare(next(iter(torch.utils.data.DataLoader(data, batch_size=8, shuffle=False))))
    losses = []
    for _ in range(12):
        loss, _ = policy(batch)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(float(loss))
    assert losses[-1] < 0.7 * losses[0]
