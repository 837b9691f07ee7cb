"""Another cloth is filmed where what is concealed hardly shows on the first."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.concealed.case import STRENGTHS, Case
from benchmarks.concealed.specimen import ENOUGH, SPECIMENS, Specimen, taken

STIFFENED = Case(("strain_stiffening",), "strong", 3)
PAIR = Case(("bending_hysteresis", "anisotropic_bending"), "medium", 3)


def tried(case, *shares):
    """What is taken, and the specimens that were made, where each effect of them comes out as `shares` say."""
    made = []

    def specimen(like):
        made.append(like)
        strengths = [share * STRENGTHS[like.strength] for share in shares[like.specimen]]
        return Specimen(
            case=like, stage=None, mesh=None, plans=(), without={}, effects=(), tracks={}, strengths=strengths
        )

    return taken(case, specimen).case.specimen, [one.specimen for one in made]


@pytest.mark.parametrize(
    ("case", "shares", "expected"),
    [
        (STIFFENED, [(1.01 * ENOUGH,)], (0, [0])),
        (STIFFENED, [(0.2,), (0.9,)], (1, [0, 1])),
        (STIFFENED, [(0.2,), (0.5,), (0.3,)], (1, [0, 1, 2])),  # none comes out: the nearest
        (PAIR, [(1.0, 0.2), (0.4, 0.4), (0.9, 0.3)], (1, [0, 1, 2])),  # by the weaker of the two
        (replace(STIFFENED, strength="weak"), [(0.2,)], (0, [0])),
        (replace(STIFFENED, motions=("fast_swing",)), [(0.2,)], (0, [0])),
        (Case((), "medium", 3), [()], (0, [0])),
    ],
)
def test_the_first_cloth_on_which_everything_comes_out_is_taken_and_else_the_nearest(case, shares, expected):
    assert tried(case, *shares) == expected


def test_specimens_are_other_cloths_and_the_first_is_the_one_that_there_was_before_there_were_others():
    others = [replace(STIFFENED, specimen=number) for number in range(SPECIMENS)]
    stiffness = [one.setting().cloth.stretch_n_m for one in others]
    assert len(set(stiffness)) == SPECIMENS
    assert stiffness[0] == STIFFENED.setting().cloth.stretch_n_m
    [first, *later] = [one.stream("motions").random(4) for one in others]
    assert not any(np.array_equal(first, draws) for draws in later)
