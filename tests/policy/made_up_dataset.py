"""Made-up trajectories: arms that go where the garment's keypoints say, so that there is something to learn."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from sim1.dataset.keypoints import KEYPOINTS
from sim1.episode import Episode, write_episode
from sim1.policy.episodes import Trajectory

FRAMES = 40
KEYPOINT_SIZE = 36


def toy_trajectory(garment: str, name: str, sources: set[str], seed: int) -> Trajectory:
    rng = np.random.default_rng(seed)
    place = rng.uniform(-1, 1, 3)
    phase = np.linspace(0, 1.3, FRAMES).clip(max=1)[:, None]  # moves, then holds
    goal = np.resize(place, 14)
    goal[[6, 13]] = 0.2
    action = phase * goal
    state = np.concatenate([action[:1], action[:-1]])
    keypoints = np.tile(place, KEYPOINT_SIZE // 3) + 0.1 * phase
    return Trajectory(
        garment=garment,
        name=name,
        sources=frozenset(sources),
        state=state.astype(np.float32),
        keypoints=keypoints.astype(np.float32),
        action=action.astype(np.float32),
    )


@dataclass(frozen=True)
class ToyDataset:
    path: Path

    def provenance(self) -> pd.DataFrame:
        return pd.read_parquet(self.path / "provenance.parquet")


def write_dataset(folder: Path, trajectories: list[Trajectory], appearances: int = 2) -> ToyDataset:
    """The tables of a `dataset` artifact (no video), each trajectory in several appearances."""
    frames, provenance, episode = [], [], 0
    for item in trajectories:
        for appearance in range(appearances):
            for frame in range(len(item.state)):
                frames.append(
                    {
                        "observation.state": item.state[frame],
                        KEYPOINTS: item.keypoints[frame],
                        "action": item.action[frame],
                        "episode_index": episode,
                        "frame_index": frame,
                    }
                )
            provenance.append(
                {
                    "episode_index": episode,
                    "garment": item.garment,
                    "trajectory": item.name,
                    "appearance": appearance,
                    "sources": sorted(item.sources),
                }
            )
            episode += 1
    data = folder / "lerobot" / "data" / "chunk-000"
    data.mkdir(parents=True)
    table = pd.DataFrame(frames)
    half = len(table) // 2  # LeRobot may cut an episode's table anywhere between two files
    table.iloc[:half].to_parquet(data / "file-000.parquet")
    table.iloc[half:].to_parquet(data / "file-001.parquet")
    pd.DataFrame(provenance).to_parquet(folder / "provenance.parquet")
    (folder / "lerobot" / "meta").mkdir()
    (folder / "lerobot" / "meta" / "info.json").write_text(json.dumps({"fps": 10}))
    names = {item.garment for item in trajectories}
    (folder / "keypoints.json").write_text(
        json.dumps({name: list(range(KEYPOINT_SIZE // 3)) for name in sorted(names)})
    )
    return ToyDataset(folder)


def toy_trajectories() -> list[Trajectory]:
    """Five of each of two garments; source 0002 is in two of five, every other motion mixes 0000 and 0001."""
    return [
        toy_trajectory(garment, f"{place:04d}", {"0002"} if place > 2 else {"0000", "0001"}, seed=10 * place + shift)
        for shift, garment in enumerate(("tshirt", "towel"))
        for place in range(5)
    ]


def write_demonstrations(folder, trajectories):
    """Real demonstrations in the cell's format: the towel's made-up trajectories at 30 Hz, and one that failed."""
    for number, item in enumerate(trajectories):
        often = [np.repeat(array, 3, axis=0) for array in (item.state, item.action, item.keypoints)]
        state, action = (array.reshape(-1, 2, 7) for array in often[:2])
        episode = Episode(
            time_s=np.arange(len(state)) / 30,
            joints_rad=state[..., :6],
            openness=state[..., 6],
            command_joints_rad=action[..., :6],
            command_openness=action[..., 6],
            garment_m=often[2].reshape(len(state), -1, 3),
            about={"success": number > 0, "sources": []},
        )
        write_episode(folder / "episodes" / f"{number:04d}", episode)
    return folder
