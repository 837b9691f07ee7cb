"""Which trials are shown as film strips, and what their titles say."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_cell import CONFIG, ObedientCell, look, start

from sim1.film_strip import FilmStrip, draw_strips, film_strip, first_of_each, laid_down, read_strip, write_strip
from sim1.policy.lessons import GENERATED, REAL, ModelKey
from sim1.policy.rollout import Driving
from sim1.policy.time_limit import TimeLimit
from sim1.policy.trial_strips import chosen, draw_trials
from sim1.policy.trials import BROKEN, Bench, Trial, TrialSettings, run_trial
from sim1.policy.worlds import SIMULATOR

PIXEL = np.zeros((2, 3, 3), np.uint8)


def row(failure, kind=GENERATED, shift="spatial"):
    return {
        "world": "stand-in reality",
        "trained_on": kind,
        "shift": shift,
        "success": failure is None,
        "failure": failure,
    }


@pytest.fixture
def shown(tmp_path):
    """Function that gives the titles of the strips of a shift; the strip of trial 7 is called "trial 7"."""

    def titles(rows, shift="spatial"):
        files = [tmp_path / f"{number}.npz" for number in range(len(rows))]
        for number, path in enumerate(files):
            write_strip(path, FilmStrip(title=f"trial {number}", times_s=(0.0,), pictures=(PIXEL,)))
        return [strip.title for strip in chosen(rows, files, shift)]

    return titles


def test_one_success_and_one_failure_of_each_class_that_occurred_are_shown_the_first_of_each(shown):
    rows = [row(failure) for failure in ("slip", "missed grasp", None, "missed grasp", None, "slip", "missed grasp")]
    assert shown(rows) == [
        "success (2 of 7): trial 2",
        "missed grasp (3 of 7): trial 1",
        "slip (2 of 7): trial 0",
    ]


def test_every_shift_and_every_source_of_training_has_its_own(shown):
    rows = [row("slip"), row(None, shift="in-domain"), row("slip", kind=REAL), row(None, kind=REAL)]
    assert shown(rows) == ["slip (1 of 1): trial 0", "success (1 of 2): trial 3", "slip (1 of 2): trial 2"]
    assert shown(rows, "in-domain") == ["success (1 of 1): trial 1"]


def test_a_picture_per_shift_says_in_which_world_it_was(tmp_path):
    rows = [row("slip"), row(None, shift="in-domain")]
    files = [tmp_path / f"{number}.npz" for number in range(len(rows))]
    for path in files:
        write_strip(path, FilmStrip(title="a trial", times_s=(0.0,), pictures=(PIXEL,)))
    figures = draw_trials(rows, files)
    assert list(figures) == ["spatial", "in-domain"]
    assert figures["spatial"].get_suptitle().startswith("Closed loop in the stand-in reality, spatial")


def test_rare_outcomes_come_after_frequent_ones_and_the_good_one_first():
    order = first_of_each(["a", "b", "b", "fine"], good="fine")
    assert [(one.outcome, one.place, one.count) for one in order] == [("fine", 3, 1), ("b", 1, 2), ("a", 0, 1)]


def test_the_title_says_who_drove_from_where_and_a_broken_simulation_is_shown_up_to_its_end():
    class Still:
        def predict(self, state, keypoints, garment):
            return np.zeros((1, 5, 14))

    bench = Bench(world=SIMULATOR, cell=ObedientCell(breaks_at=5), start=start(), judge=lambda history: None, look=look)
    limits = {"towel": TimeLimit(duration_s=3.0, longest_of=REAL)}
    settings = TrialSettings(driving=Driving(rate_hz=10, replan_frames=5, decay=0.0), limits=limits, config=CONFIG)
    trial = Trial(model=ModelKey(REAL, 4, 1), garment="towel", shift="spatial", number=3)
    made, strip = run_trial(bench, trial, Still(), np.arange(4), settings)
    assert made["failure"] == BROKEN
    where = laid_down(made["shift_x_m"], made["shift_y_m"], made["turn_rad"])
    assert strip.title == f"towel, after 4 real demonstrations (stand-in), network seed 1, trial 3, {where}"
    assert strip.times_s == pytest.approx([frame / 30 for frame in range(5)])  # the fifth step never ended


def test_a_strip_has_the_first_and_the_last_frame_and_reads_back(tmp_path):
    history = np.arange(101.0)[:, None, None]
    strip = film_strip("a run", history, lambda garment_m: np.full((2, 2, 3), garment_m[0, 0], np.uint8))
    assert (strip.pictures[0].max(), strip.pictures[-1].min()) == (0, 100)
    write_strip(tmp_path / "strip.npz", strip)
    again = read_strip(tmp_path / "strip.npz")
    assert (again.title, again.times_s) == (strip.title, strip.times_s)
    np.testing.assert_array_equal(again.pictures, strip.pictures)
    assert len(draw_strips("Two runs", [strip, strip]).subfigs) == 2


def test_a_long_title_is_broken_into_lines_and_none_is_cut_off(tmp_path):
    title = "missed grasp (46 of 50): towel, network seed 0, trial 0, moved +11, -67 mm, turned -10°; houndstooth on ceramic_tiles, light overcast_windows, camera +5°, friction × 0.6"
    strip = FilmStrip(title=title, times_s=(0.0,) * 6, pictures=(np.zeros((72, 96, 3), np.uint8),) * 6)
    figure = draw_strips("Closed loop", [strip, replace(strip, title="success (2 of 50): towel")])
    figure.savefig(tmp_path / "strips.png")  # lays it out
    for part in figure.subfigs:
        words, room = part.texts[0].get_window_extent(), part.bbox
        assert room.x0 <= words.x0
        assert words.x1 <= room.x1
        for axes in part.axes:
            assert axes.get_window_extent().y1 <= words.y0
    assert [part.get_suptitle().count("\n") for part in figure.subfigs] == [1, 0]
