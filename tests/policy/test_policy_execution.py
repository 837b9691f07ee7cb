import numpy as np
import pytest

from sim1.policy.execution import ChunkExecution


def numbered(calls: list[int]):
    """Chunk k says 100 k + frame of the chunk."""

    def predict(_):
        calls.append(len(calls))
        return 100.0 * calls[-1] + np.arange(4.0)[:, None]

    return predict


def test_receding_horizon_executes_the_first_commands_of_each_chunk():
    calls: list[int] = []
    run = ChunkExecution(numbered(calls), replan_frames=2, decay=1e3)
    assert [run.upcoming(np.zeros(1)).item() for _ in range(6)] == [0, 1, 100, 101, 200, 201]
    assert len(calls) == 3


def test_ensembling_averages_every_chunk_that_still_speaks_of_the_frame():
    run = ChunkExecution(numbered([]), replan_frames=2, decay=0.0)
    said = [run.upcoming(np.zeros(1)).item() for _ in range(5)]
    # frame 2: chunk 0 says 2, chunk 1 says 100; frame 4: chunk 0 is over, chunk 1 says 102, chunk 2 says 200
    assert said == [0, 1, 51, 52, 151]


def test_newer_chunks_weigh_more():
    run = ChunkExecution(numbered([]), replan_frames=1, decay=np.log(3.0))
    run.upcoming(np.zeros(1))
    assert run.upcoming(np.zeros(1)).item() == pytest.approx((1 * 1 + 3 * 100) / 4)


def test_a_chunk_shorter_than_its_execution_is_refused():
    run = ChunkExecution(lambda _: np.zeros((2, 1)), replan_frames=3, decay=0.0)
    run.upcoming(np.zeros(1))
    run.upcoming(np.zeros(1))
    with pytest.raises(ValueError, match="no chunk reaches frame 2"):
        run.upcoming(np.zeros(1))


def test_looking_ahead_does_not_move_the_clock():
    run = ChunkExecution(numbered([]), replan_frames=2, decay=1e3)
    assert run.upcoming(np.zeros(1), count=3)[:, 0].tolist() == [0, 1, 2]
    assert run.upcoming(np.zeros(1), count=2)[:, 0].tolist() == [1, 2]
    assert run.upcoming(np.zeros(1)).item() == 100
