"""Pictures are shared out among workers: each once, in the order of its clip, a clip to one worker as far as that goes."""

from collections import deque

from hypothesis import given
from hypothesis import strategies as st

from sim1.render.blender import crew_size
from sim1.render.shares import BATCH, Order, Shares


def missing(**counts: int) -> dict[str, list[tuple[str, int]]]:
    return {clip: [("head", frame) for frame in range(count)] for clip, count in counts.items()}


def rendered(counts: dict[str, int], workers: int) -> list[list[Order]]:
    """Orders of each worker, where all are equally fast."""
    shares, taken = Shares(missing(**counts)), [[] for _ in range(workers)]
    ready = deque(taken)
    while ready:
        mine = ready.popleft()
        if order := shares.take(mine[-1].clip if mine else None):
            mine.append(order)
            ready.append(mine)
    return taken


def clips(orders: list[Order]) -> list[str]:
    """Clips in the order in which a worker sets them up."""
    return [order.clip for before, order in zip([None, *orders], orders) if before is None or before.clip != order.clip]


@given(counts=st.lists(st.integers(0, 40), max_size=6), workers=st.integers(1, 5))
def test_every_picture_is_rendered_once_and_no_worker_does_much_more_than_another(counts, workers):
    counts = {f"clip{number}": count for number, count in enumerate(counts)}
    taken = rendered(counts, workers)
    pictures = [(order.clip, picture) for orders in taken for order in orders for picture in order.pictures]
    assert sorted(pictures) == [(clip, picture) for clip, row in missing(**counts).items() for picture in row]
    orders = [len(row) for row in taken]
    assert max(orders) - min(orders) <= 1
    assert sum(orders) == Shares(missing(**counts)).batches


def test_each_worker_stays_with_a_clip_of_its_own_and_the_last_one_is_shared():
    first, second = rendered({"a": 5 * BATCH, "b": 5 * BATCH, "c": 4 * BATCH}, workers=2)
    assert clips(first) == ["a", "c"]
    assert clips(second) == ["b", "c"]
    assert len(first) == len(second) == 7


def test_a_clip_that_nobody_has_begun_comes_before_a_longer_one_that_somebody_has():
    shares = Shares(missing(long=9 * BATCH, short=2 * BATCH))
    assert shares.take(None).clip == "long"
    assert shares.take(None).clip == "short"
    assert shares.take(None).clip == "long"


def test_one_clip_is_shared_by_all():
    assert [len(row) for row in rendered({"only": 4 * BATCH}, workers=4)] == [1, 1, 1, 1]


def test_an_order_is_read_as_it_was_sent():
    order = Order(clip="0007_v1", pictures=(("head", 3), ("left_wrist", 3)))
    assert Order.of(order.line()) == order


def test_there_is_a_worker_per_core_with_a_thread_each_unless_there_is_less_to_do():
    free = {"workers": 0, "threads": 0}
    assert crew_size(free, batches=100, cores=16) == (16, 1)
    assert crew_size(free, batches=3, cores=16) == (3, 5)
    assert crew_size(free, batches=0, cores=16)[0] == 0
    assert crew_size({"workers": 1, "threads": 0}, batches=100, cores=16) == (1, 16)
    assert crew_size({"workers": 4, "threads": 2}, batches=100, cores=16) == (4, 2)
    assert crew_size({"workers": 40, "threads": 0}, batches=100, cores=16) == (40, 1)
