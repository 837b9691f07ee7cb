"""Who may end a search, and how."""

import signal

import pytest

from sim1.mismatch.patience import Patience


@pytest.fixture
def default_interrupts():
    """Both signals end a program, as they do outside of tests; here by the same error, so that the tests go on."""
    before = {number: signal.signal(number, signal.default_int_handler) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("second", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("first", [signal.SIGINT, signal.SIGTERM])
def test_the_first_interrupt_ends_the_search_and_the_second_the_program(default_interrupts, first, second):
    patience = Patience()

    def interrupted_twice():
        with patience.interruptible():
            assert not patience.over
            signal.raise_signal(first)
            assert patience.over
            signal.raise_signal(second)

    with pytest.raises(KeyboardInterrupt):
        interrupted_twice()
    assert signal.getsignal(signal.SIGINT) is signal.getsignal(signal.SIGTERM) is signal.default_int_handler


def test_a_program_that_was_started_undisturbed_by_ctrl_c_stays_so_and_still_hears_a_kill(default_interrupts):
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    patience = Patience()
    with patience.interruptible():
        signal.raise_signal(signal.SIGINT)
        assert not patience.over
        signal.raise_signal(signal.SIGTERM)
        assert patience.over
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
