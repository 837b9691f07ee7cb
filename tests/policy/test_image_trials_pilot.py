"""What an image policy is given while it drives: in form and content what the dataset gives it of the same states."""

from types import SimpleNamespace

import numpy as np
import pytest
from made_up_cell import ObedientCell, start
from painted_world import POLICIES, Painter, write_world

from sim1.policy.episodes import STATE
from sim1.policy.image.build import policy_config
from sim1.policy.image.frames import loader, open_frames, read_features, seen_by
from sim1.policy.image.policy_file import PolicyFile
from sim1.policy.image_trials.pilot import CAMERA, ImagePilot, steps_seen
from sim1.policy.rollout import Driving, roll_out
from sim1.stage import BadInput

pytestmark = pytest.mark.filterwarnings("ignore")  # of torch and torchvision, not of this project
HEAD = f"{CAMERA}head"


class Listening:
    """In place of a trained policy: notes what it is given, and commands the arms to joint 0 at 0.3, 0.6, ..."""

    def __init__(self, steps, cameras=(HEAD,)):
        config = SimpleNamespace(observation_delta_indices=steps, image_features=dict.fromkeys(cameras), type="made up")
        self.policy, self.given = SimpleNamespace(config=config), []

    def answer(self, batch):
        self.given.append(batch)
        return np.full((1, 9, 14), 0.3 * len(self.given))


class Photographer:
    """In place of the live camera: a picture tells its frame's number, and joint 0 at that moment."""

    def __init__(self):
        self.taken = []

    def __call__(self, *, garment_m, joints_rad, openness, frame):
        self.taken.append(frame)
        return {"head": np.full((2, 3, 3), [frame, round(100 * joints_rad[0, 0]), 255], np.uint8)}


def drive(trained, replan_frames: int, frames: int):
    photographer = Photographer()
    pilot = ImagePilot(trained, 5, "fold the towel", photographer)
    driving = Driving(rate_hz=10, replan_frames=replan_frames, decay=1e3)  # the newest chunk alone
    list(roll_out(ObedientCell(), start(), pilot, driving, frames / 10))
    return photographer, pilot


def test_a_policy_of_the_present_gets_a_picture_of_it_whenever_it_plans_and_none_is_made_between():
    trained = Listening(None)
    photographer, pilot = drive(trained, replan_frames=3, frames=7)
    assert photographer.taken == [0, 3, 6]
    first, second, _ = trained.given
    assert set(first) == {STATE, HEAD, "task"}
    assert first["task"] == ["fold the towel"]
    assert (first[STATE].shape, first[HEAD].shape) == ((1, 14), (1, 3, 2, 3))
    assert second[STATE][0, 0].item() == pytest.approx(0.3)  # what the first chunk led to
    np.testing.assert_allclose(second[HEAD][0, :, 0, 0].numpy(), np.array([3, 30, 255]) / 255, rtol=1e-6)
    assert [frame for frame, _ in pilot.film] == [0, 3, 6]


def test_a_policy_that_looks_back_gets_the_frames_before_at_its_own_rate_the_first_one_repeated():
    trained = Listening([-2, -1, 0])
    photographer, _ = drive(trained, replan_frames=2, frames=5)
    assert sorted(photographer.taken) == [0, 1, 2, 3, 4]  # each once
    numbers = [(255 * batch[HEAD][0, :, 0, 0, 0]).round().int().tolist() for batch in trained.given]
    assert numbers == [[0, 0, 0], [0, 1, 2], [2, 3, 4]]
    padded = [batch[f"{HEAD}_is_pad"][0].tolist() for batch in trained.given]
    assert padded == [[True, True, False], [False] * 3, [False] * 3]
    assert [batch[STATE].shape for batch in trained.given] == [(1, 3, 14)] * 3


def test_frames_that_no_chunk_needs_are_never_made():
    trained = Listening([-1, 0])
    photographer, _ = drive(trained, replan_frames=4, frames=9)
    assert photographer.taken == [0, 3, 4, 7, 8]


def test_commands_beyond_those_that_count_are_left_out():
    trained = Listening(None)
    pilot = ImagePilot(trained, 5, "", Photographer())
    pilot.see(_cell())
    assert pilot.plan().shape == (5, 14)


def _cell() -> ObedientCell:
    cell, begin = ObedientCell(), start()
    cell.reset(begin.garment_m, begin.joints_rad, begin.openness)
    return cell


def test_a_policy_that_sees_what_is_to_come_cannot_drive():
    with pytest.raises(BadInput, match=r"sees frames to come \(up to 2\).*`policy` of stage image_policy"):
        steps_seen(SimpleNamespace(observation_delta_indices=[0, 2], type="seer"))


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sim1.render.blender.run_blender", Painter())
        return write_world(tmp_path_factory.mktemp("world"), sources={"0000": "0000"}, frame_count=10)["dataset"][""]


@pytest.mark.parametrize(
    ("kind", "settings"),
    [("act", {}), ("diffusion", {"down_dims": [32, 64]}), ("smolvla", {})],
    ids=lambda x: str(x)[:9],
)
def test_it_is_what_the_dataset_gives_in_training_names_shapes_and_types(dataset, kind, settings):
    file = PolicyFile(title="", type=kind, settings=settings)
    path = POLICIES / f"{kind}.yaml"
    config = policy_config(path, file, "tiny", features=read_features(dataset), chunk_frames=4, device="cpu")
    frames = open_frames(dataset, [0], config, commands=False)
    shown = seen_by(config, next(iter(loader(frames, batch_size=1, shuffle=False))), commands=False)

    trained = Listening(config.observation_delta_indices, config.image_features)
    size = shown[HEAD].shape[-2:]
    pilot = ImagePilot(trained, 4, shown["task"][0], lambda **_: {"head": np.zeros((*size, 3), np.uint8)})
    pilot.see(_cell())
    pilot.plan()
    (given,) = trained.given

    def form(batch):
        return {name: (value.shape, value.dtype) if name != "task" else value for name, value in batch.items()}

    assert form(given) == form(shown)
