"""Progress of long commands in a log, and of a part of the work within the whole."""

from assets_defs._progress import LINE_S, lines
from sim1.progress import listening, report, within


def test_a_log_gets_a_line_a_minute_with_the_time_left():
    now, said = [0.0], []
    tell = lines(2.0, said.append, lambda: now[0])
    for at_s, done in ((1.0, 0.0), (LINE_S - 1, 0.1), (LINE_S, 0.5), (LINE_S + 5, 0.6), (2 * LINE_S + 1, 1.0)):
        now[0] = at_s
        tell(done, f"at {at_s:.0f}")
    assert said == ["25 % after 1 min, about 3 min left: at 60", "50 % after 2 min, about 2 min left: at 121"]


def test_before_anything_is_done_no_time_left_is_claimed():
    now, said = [0.0], []
    tell = lines(1.0, said.append, lambda: now[0])
    now[0] = LINE_S
    tell(0.0, "reading")
    assert said == ["0 % after 1 min: reading"]


def test_a_part_of_the_work_is_told_as_a_share_of_the_whole():
    said = []
    with listening(lambda done, total, what: said.append((round(done / total, 3), what))):
        with within(0.2, 0.6):
            report(0, 4, "first")
            with within(0.5, 1.0):
                report(1, 2, "inner")
            report(4, 4, "last")
        report(3, 4, "outside")
    assert said == [(0.2, "first"), (0.5, "inner"), (0.6, "last"), (0.75, "outside")]


def test_a_part_of_unknown_size_is_at_its_beginning_and_without_a_listener_nothing_is_told():
    said = []
    with listening(lambda done, total, what: said.append(done)), within(0.3, 0.9):
        report(5, 0, "unknown")
    assert said == [0.3]
    with within(0.0, 1.0):
        report(1, 2, "nobody listens")
