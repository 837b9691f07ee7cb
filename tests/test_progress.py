"""Progress of long commands in a log."""

from assets_defs._progress import LINE_S, lines


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
