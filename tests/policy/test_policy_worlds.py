"""Success in the simulator that made the training data is not called success in the stand-in reality."""

import pandas as pd

from sim1.policy.worlds import REALITY, SIMULATOR, said_of_worlds, together, worlds_of


def test_a_page_says_where_each_garment_was_driven():
    table = pd.DataFrame({"world": [REALITY, REALITY, SIMULATOR], "garment": ["towel", "towel", "mine"]})
    worlds = worlds_of(table)
    assert worlds == {REALITY: ["towel"], SIMULATOR: ["mine"]}
    real, simulated, both = said_of_worlds(worlds)
    assert "concealed fabric" in real
    assert real.endswith(": towel.")
    assert "made the training data" in simulated
    assert simulated.endswith(": mine.")
    assert "both worlds" in both
    assert said_of_worlds({SIMULATOR: ["mine"]}) == [simulated]
    assert said_of_worlds(worlds_of(table[:0])) == []


def test_worlds_of_several_variants_stand_together():
    assert together([{REALITY: ["towel"]}, {SIMULATOR: ["mine"]}, {REALITY: ["shorts", "towel"]}]) == {
        SIMULATOR: ["mine"],
        REALITY: ["shorts", "towel"],
    }
