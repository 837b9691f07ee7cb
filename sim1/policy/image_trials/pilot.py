"""An image policy in control: what it is given, made of the cell's states, in the form in which the dataset gives it."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from lerobot.configs import PreTrainedConfig

from sim1.policy.episodes import STATE
from sim1.policy.image.build import Trained
from sim1.policy.image.frames import Batch
from sim1.policy.rollout import Cell, arm_state
from sim1.stage import BadInput

CAMERA = "observation.images."  # begin of a camera's column in the dataset

type Look = Callable[..., dict[str, np.ndarray]]
"""Pictures by camera of a state, see `sim1.render.live_camera.LiveCamera.pictures`."""


@dataclass
class Moment:
    """A policy frame that was seen. Its pictures are made when the policy asks for them, and kept."""

    frame: int
    state: np.ndarray  # (14,) f32
    garment_m: np.ndarray  # (v, 3)
    joints_rad: np.ndarray  # (2, 6)
    openness: np.ndarray  # (2,)
    pictures: dict[str, np.ndarray] | None = None  # camera -> (h, w, 3) u8

    def shown_by(self, look: Look) -> dict[str, np.ndarray]:
        if self.pictures is None:
            self.pictures = look(
                garment_m=self.garment_m, joints_rad=self.joints_rad, openness=self.openness, frame=self.frame
            )
        return self.pictures


class ImagePilot:
    """A policy of lerobot's as a `Pilot`.

    Args:
        trained: the policy.
        chunk_frames: commands of an answer that count, as in the measure of its error.
        task: in words, for policies that read.
        look: makes pictures.

    Attributes:
        film: frames in which it planned, with what its first camera showed then.
    """

    def __init__(self, trained: Trained, chunk_frames: int, task: str, look: Look) -> None:
        self._trained, self._chunk_frames, self._task, self._look = trained, chunk_frames, task, look
        self._steps = steps_seen(trained.policy.config)
        self._moments: deque[Moment] = deque(maxlen=1 - min(self._steps or (0,)))
        self._frame = 0
        self.film: list[tuple[int, np.ndarray]] = []

    def see(self, cell: Cell) -> None:
        moment = Moment(
            frame=self._frame,
            state=arm_state(cell).astype(np.float32),
            garment_m=np.array(cell.garment_m),
            joints_rad=np.array(cell.joints_rad),
            openness=np.array(cell.openness),
        )
        self._moments.append(moment)
        self._frame += 1

    def plan(self) -> np.ndarray:
        chunk = self._trained.answer(self._batch())[0, : self._chunk_frames]
        now = self._moments[-1]
        self.film.append((now.frame, now.pictures[min(now.pictures)]))
        return chunk

    def _batch(self) -> Batch:
        """As the dataset gives the frame that was seen last: before the first one there were others like it."""
        last = len(self._moments) - 1
        seen = [self._moments[max(0, last + step)] for step in self._steps or (0,)]
        arrays = {STATE: np.stack([moment.state for moment in seen])}
        for name in self._trained.policy.config.image_features:
            pictures = [moment.shown_by(self._look)[name.removeprefix(CAMERA)] for moment in seen]
            arrays[name] = np.stack(pictures).transpose(0, 3, 1, 2).astype(np.float32) / 255.0
        batch: Batch = {"task": [self._task]}
        for name, array in arrays.items():
            one_picture = len(seen) == 1 and name != STATE  # lerobot leaves out its dimension for time
            batch[name] = torch.from_numpy(array if self._steps is None or one_picture else array[None])
            if self._steps is not None:
                batch[f"{name}_is_pad"] = torch.tensor([[last + step < 0 for step in self._steps]])
        return batch


def steps_seen(config: PreTrainedConfig) -> tuple[int, ...] | None:
    """Frames that the policy sees, 0 the present; None: the present, without a dimension for time.

    Raises:
        BadInput: it wants to see what is to come.
    """
    steps = config.observation_delta_indices
    if steps is not None and max(steps) > 0:
        raise BadInput(
            f"a {config.type} policy sees frames to come (up to {max(steps)}), so it cannot drive; choose another with the "
            "setting `policy` of stage image_policy"
        )
    return None if steps is None else tuple(steps)
