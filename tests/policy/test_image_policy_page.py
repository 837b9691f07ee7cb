"""What the page of an image policy says of its errors, and of how many trajectories it says nothing."""

import numpy as np
import pandas as pd
import pytest

from sim1.policy.image.measures import BLANK, DATASET, measure
from sim1.policy.image.page import result_section
from sim1.policy.image.shifts import IN_DOMAIN


def said(folder, count, *, hold_rad=0.5, shown=True, demonstrations=None):
    """Of so many trajectories, on all of which the policy does worse in other light and worst without a picture."""
    level = np.linspace(0.1, 0.2, count)
    pictures = ((DATASET, 0.0), (IN_DOMAIN, 0.0), ("lighting", 0.02), (BLANK, 0.3))
    rows = [
        {"seed": 0, "pictures": name, "garment": "towel", "trajectory": str(place),
         "source": str(place % (demonstrations or count)), "appearance": 0, "joint_error_rad": own + more,
         "openness_error": 0.1, "hold_joint_error_rad": hold_rad, "hold_openness_error": 0.1}
        for name, more in (pictures if shown else pictures[:1])
        for place, own in enumerate(level)
    ]  # fmt: skip
    section = result_section("Result", folder, measure(pd.DataFrame(rows), seed=0))
    return " ".join(section.paragraphs), section.table


@pytest.mark.parametrize("count", [1, 2, 4, 7])
def test_of_few_trajectories_it_is_said_how_many_and_nothing_else(tmp_path, count):
    words, table = said(tmp_path, count, hold_rad=0.1)
    number = "1 trajectory of 1 demonstration" if count == 1 else f"{count} trajectories of {count} demonstrations"
    assert words.count(f"{number} are too few to tell, 8 of 2 are the least") == 2
    for verdict in ("it looks", "The joint error grows", "established", "no better than standing still"):
        assert verdict not in words
    assert len(table) == 4  # the figures themselves stand there


def test_from_eight_on_it_is_said_what_the_intervals_tell(tmp_path):
    words, _ = said(tmp_path, 8)
    assert "the policy does worse: it looks" in words
    assert "The joint error grows, beyond its interval, with: other lighting." in words
    assert "too few" not in words
    assert "no better than standing still" in said(tmp_path, 8, hold_rad=0.1)[0]


def test_trajectories_of_one_demonstration_are_too_few_however_many_and_it_is_said_why_they_have_no_interval(tmp_path):
    words, table = said(tmp_path, 23, hold_rad=0.1, demonstrations=1)
    assert words.count("23 trajectories of 1 demonstration are too few to tell") == 2
    assert "One held-out demonstration alone has no interval" in words
    assert "it looks" not in words
    assert table[0]["Joint error (degrees)"] == "8.59"
    words, table = said(tmp_path, 23, demonstrations=2)
    assert "too few" not in words
    assert "Student's quantile for as many demonstrations as there are" in words
    assert table[0]["Joint error (degrees)"].startswith("8.59 (")


def test_without_changed_pictures_that_is_said_whatever_the_number(tmp_path):
    assert "No trajectory was rendered anew" in said(tmp_path, 2, shown=False)[0]
