"""Success in every shift, and what a shift changes, pair by pair."""

import pandas as pd

from sim1.policy.image_trials.measures import measure, of_all


def test_a_change_is_counted_pair_by_pair():
    wins = {"in-domain": [1, 1, 0, 0], "lighting": [1, 0, 0, 0], "viewpoint": [0, 0, 1, 0]}
    rows = [
        {"garment": "towel", "shift": shift, "trial": number, "success": bool(won), "failure": None if won else "slip"}
        for shift, all_of in wins.items()
        for number, won in enumerate(all_of)
    ]
    tried = {one.shift: one for one in measure(pd.DataFrame(rows), seed=0)}
    assert tried["in-domain"].change is None
    assert tried["lighting"].change.value == -0.25
    assert tried["lighting"].change.interval == (-0.75, 0.0)
    assert tried["viewpoint"].change.value == -0.25
    assert tried["viewpoint"].change.interval.high > 0
    assert tried["viewpoint"].failures == {"slip": 3}
    alone = [row for row in rows if row["shift"] == "lighting"]
    assert measure(pd.DataFrame(alone), seed=0)[0].change is None


def test_several_garments_are_counted_together_and_each_by_itself():
    rows = [
        {
            "garment": garment,
            "shift": "in-domain",
            "trial": number,
            "success": garment == "towel",
            "failure": None if garment == "towel" else "slip",
        }
        for garment in ("towel", "polo")
        for number in range(3)
    ]
    tried = measure(pd.DataFrame(rows), seed=0)
    assert [(one.garment, one.success_count, one.trial_count) for one in tried] == [
        (None, 3, 6),
        ("towel", 3, 3),
        ("polo", 0, 3),
    ]
    assert of_all(tried) == tried[:1]
