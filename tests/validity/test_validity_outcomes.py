"""What became of generated attempts, and which of them are shown."""

import numpy as np
import pytest
from validity_synthetic import SHEET, an_episode, folding

from sim1.episode import write_episode
from sim1.validity import outcomes
from sim1.validity.outcomes import draw_outcomes, outcome


def decision(success=True, failure=None, reasons="", **more):
    return {"accepted": not reasons, "success": success, "failure": failure, "reasons": reasons, **more}


@pytest.mark.parametrize(
    ("row", "word"),
    [
        (decision(), "accepted"),
        (decision(success=False, failure="slip", reasons="judge: slip; rules: end.iou <= 1, is 2"), "slip"),
        (decision(reasons="rules: end.iou <= 1, is 2; video: score 0.1 below 0.5"), "rejected by rule"),
        (decision(reasons="video: score 0.1 below 0.5"), "rejected by video"),
        (decision(success=False, failure="slip"), "accepted, though slip"),  # a variant may switch the judge off
    ],
)
def test_every_attempt_is_accepted_or_has_a_class_of_failure_or_a_filter_that_rejected_it(row, word):
    assert outcome(row) == word


def test_the_first_episode_of_each_outcome_is_shown_with_class_place_and_seed(tmp_path, monkeypatch):
    rng, rows = np.random.default_rng(0), []
    judged = [
        ("slip", "judge: slip"),
        (None, ""),
        (None, "rules: a"),
        (None, "video: b"),
        ("slip", "judge: slip"),
        (None, ""),
    ]
    for number, (failure, reasons) in enumerate(judged):
        more = {"episode": f"{number:04d}", "ran": True, "perturbed": number == 3}
        rows.append(decision(failure is None, failure, reasons, **more))
        write_episode(tmp_path / f"{number:04d}", an_episode(folding(1.0, rng, turn_rad=0.1), seed=5))
    rows.append(decision(False, "unreachable", "did not run: unreachable", episode="0006", ran=False, perturbed=False))
    drawn = []
    monkeypatch.setattr(outcomes, "draw_strips", lambda heading, strips: drawn.extend([heading, *strips]))
    monkeypatch.setattr(outcomes, "save_figure", lambda *_, **__: None)
    picture = tmp_path / "film_strips.png"
    start_m = SHEET.rest_m.astype(np.float32)
    draw_outcomes(picture, "sheet", rows, tmp_path, start_m, lambda garment_m: np.zeros((2, 2, 3), np.uint8))
    heading, *strips = drawn
    assert heading.endswith("the first of each outcome, of 6 that ran")
    begins = [strip.title.split(", moved")[0] for strip in strips]
    assert begins == [
        "accepted (2 of 6): sheet, attempt 0001 of seed 5",
        "slip (2 of 6): sheet, attempt 0000 of seed 5",
        "rejected by rule (1 of 6): sheet, attempt 0002 of seed 5",
        "rejected by video (1 of 6): sheet, attempt 0003 of seed 5",
    ]
    assert strips[3].title.endswith("turned +6°, disturbed on purpose")
