import numpy as np
import pytest

from sim1.policy.execution import ChunkExecution
from sim1.policy.rollout import Driving, Start, StatePilot, roll_out


def numbered(calls: list[int]):
    """Chunk k says 100 k + frame of the chunk."""

    def predict():
        calls.append(len(calls))
        return 100.0 * calls[-1] + np.arange(4.0)[:, None]

    return predict


def test_receding_horizon_executes_the_first_commands_of_each_chunk():
    calls: list[int] = []
    run = ChunkExecution(numbered(calls), replan_frames=2, decay=1e3)
    assert [run.command().item() for _ in range(6)] == [0, 1, 100, 101, 200, 201]
    assert len(calls) == 3


def test_ensembling_averages_every_chunk_that_still_speaks_of_the_frame():
    run = ChunkExecution(numbered([]), replan_frames=2, decay=0.0)
    said = [run.command().item() for _ in range(5)]
    # frame 2: chunk 0 says 2, chunk 1 says 100; frame 4: chunk 0 is over, chunk 1 says 102, chunk 2 says 200
    assert said == [0, 1, 51, 52, 151]


def test_newer_chunks_weigh_more():
    run = ChunkExecution(numbered([]), replan_frames=1, decay=np.log(3.0))
    run.command()
    assert run.command().item() == pytest.approx((1 * 1 + 3 * 100) / 4)


def test_a_chunk_shorter_than_its_execution_is_refused():
    run = ChunkExecution(lambda: np.zeros((2, 1)), replan_frames=3, decay=0.0)
    run.command()
    run.command()
    with pytest.raises(ValueError, match="no chunk reaches frame 2"):
        run.command()


class ListedCell:
    """Arms are where they are told to be; every command is kept."""

    def reset(self, garment_m, joints_rad, openness):
        self.garment_m, self.joints_rad, self.openness, self.commands = garment_m, joints_rad, openness, []

    def step(self, joints_rad, openness):
        self.joints_rad, self.openness = joints_rad, openness
        self.commands.append(joints_rad[0, 0])


def test_what_is_said_in_a_frame_is_reached_by_the_next_and_on_an_even_way():
    """From 0 to 0.3, on to 0.9 and back to 0: three cell frames each."""

    class Reciting:
        def predict(self, state, keypoints, garment):
            return np.repeat(np.array([0.3, 0.9, 0.0])[None, :, None], 14, axis=2)

    begin = Start(garment_m=np.zeros((4, 3)), joints_rad=np.zeros((2, 6)), openness=np.zeros(2))
    cell, driving = ListedCell(), Driving(rate_hz=10, replan_frames=3, decay=0.0)
    pilot = StatePilot(Reciting(), "towel", np.arange(4))
    list(roll_out(cell, begin, pilot, driving, duration_s=0.3))
    assert cell.commands == pytest.approx([0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 0.6, 0.3, 0.0])


def test_a_pilot_sees_every_policy_frame_and_is_asked_in_those_alone_in_which_a_chunk_is_wanted():
    class Counting:
        seen, asked = 0, ()

        def see(self, cell):
            self.seen += 1

        def plan(self):
            self.asked += (self.seen,)
            return np.zeros((4, 14))

    begin = Start(garment_m=np.zeros((4, 3)), joints_rad=np.zeros((2, 6)), openness=np.zeros(2))
    pilot, driving = Counting(), Driving(rate_hz=10, replan_frames=3, decay=0.0)
    list(roll_out(ListedCell(), begin, pilot, driving, duration_s=0.8))
    assert pilot.seen == driving.frame_count(0.8) == 8
    assert pilot.asked == (1, 4, 7)
