"""Who may end a search, and how."""

import signal
from dataclasses import replace

import pytest
from small_bundle import empty_bundle

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.patience import Patience
from sim1.mismatch.stage import CalibratedPhysicsConfig, calibrated_physics
from sim1.recording.bundle import write_bundle


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


@pytest.mark.parametrize(("budget_minutes", "ends"), [(None, False), (0.5, True)])
def test_the_stage_s_search_ends_when_its_budget_would_not_last_for_the_rest(
    tmp_path, monkeypatch, budget_minutes, ends
):
    told = []

    def diagnosed(given, *, progress, patience):
        told.append(patience)
        raise NotConverged("enough is known")

    monkeypatch.setattr("sim1.mismatch.calibrated.diagnose", diagnosed)
    write_bundle(tmp_path / "bundle", replace(empty_bundle(motions=2), noise_std_m=3e-4))
    config = CalibratedPhysicsConfig(budget_minutes=budget_minutes)
    with pytest.raises(NotConverged):
        calibrated_physics({"recordings": {"towel": tmp_path}}, tmp_path / "out", config)
    [patience] = told
    assert not patience.over
    patience.reserve_s = 60.0
    assert patience.over is ends


def test_a_budget_in_which_nothing_can_be_done_is_refused():
    with pytest.raises(ValueError, match="greater than or equal to"):
        CalibratedPhysicsConfig(budget_minutes=0.1)
