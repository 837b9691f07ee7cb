"""What a located force depends on is told in words, and what it does not: held against forces that are known."""

import re
from dataclasses import replace

import numpy as np
import pytest
from swung_sheet import SIDE_M, noise, pushed, swung

from pipeline.home import REPOSITORY
from sim1.mismatch.dependence import LEVEL
from sim1.mismatch.shares import Shares
from sim1.mismatch.state import asked_of, table_of
from sim1.mismatch.state_words import words_of

NOWHERE = np.zeros(25, bool)
PLACE = np.isin(np.arange(25), [6, 7, 11, 12])
X, Y, Z = np.eye(3)
SPEED = "the speed across the sheet"
ALL = {
    "a direction in the room",
    "the sheet's normal",
    SPEED,
    "the speed along the sheet",
    "the speed either way",
    "the acceleration",
    "the curvature",
    "the strain",
    "the table",
    "how far along x",
    "how far along y",
    "the height",
    "the distance from the grips",
    "the place on the cloth",
}


def across(one, vector):
    return (vector * one.states.normal).sum(-1, keepdims=True) * one.states.normal


def quadratic_drag(one):
    through = across(one, one.velocity_m_s)
    return -2e-3 * np.linalg.norm(through, axis=-1, keepdims=True) * through


def linear_drag(one):
    return -2e-3 * across(one, one.velocity_m_s)


def constant_push(one):
    return 1e-3 * X + 5e-4 * Y


def push_in_one_place(one):
    return -2e-3 * PLACE[:, None] * Z


def on_table(one):
    return (one.path_m[..., 2] < one.table_z_m + 1e-3)[..., None]


def friction_on_the_table(one):
    flat = one.velocity_m_s * (X + Y)
    return -1e-3 * on_table(one) * flat / np.maximum(np.linalg.norm(flat, axis=-1, keepdims=True), 1e-3)


def adhesion_to_the_table(one):
    return -1e-3 * on_table(one) * Z


def curl(one):
    return 1e-4 * one.states.curvature_1_m[..., 1, None] * one.states.normal


def pull_of_the_threads(one):
    return 0.1 * one.states.strain[..., 1, None] * one.states.threads[:, :, 1]


def carried_air(one):
    return -1e-3 * across(one, np.gradient(one.velocity_m_s, one.time_s, axis=0))


def push_near_the_grips(one):
    return (SIDE_M - one.states.grip_m)[..., None] * Y


def lift(one):
    return (one.velocity_m_s**2).sum(-1, keepdims=True) * Z


def jet(one):
    """Blows along z, the more the farther along y."""
    return (one.path_m[..., 1, None] + 0.1) * Z


def nothing(one):
    return 0.0 * Z


def told(forces, place=NOWHERE):
    asked = asked_of(forces, place)
    return words_of(asked), {row.name: row for row in table_of(asked)}


@pytest.mark.parametrize(
    ("force", "place", "words", "on"),
    [
        (quadratic_drag, NOWHERE, "it brakes with the square of the speed across the sheet (100 % of it)", {SPEED}),
        (linear_drag, NOWHERE, "it brakes in proportion to the speed across the sheet (100 % of it)", {SPEED}),
        (constant_push, NOWHERE, "it pushes the same way in the room (100 % of it)", {"a direction in the room"}),
        (
            push_in_one_place,
            PLACE,
            "it pushes the same way in the room (16 % of it) and is stronger in one place of the cloth (84 % of it)",
            {"a direction in the room", "the place on the cloth"},
        ),
        (friction_on_the_table, NOWHERE, "it brakes by as much at any speed on the table (100 % of it)", {"the table"}),
        (adhesion_to_the_table, NOWHERE, "it pushes up or down on the table (100 % of it)", {"the table"}),
        (curl, NOWHERE, "it pushes along the normal in proportion to the curvature (100 % of it)", {"the curvature"}),
        (pull_of_the_threads, NOWHERE, "it pulls along the threads in proportion to the strain (100", {"the strain"}),
        (carried_air, NOWHERE, "it resists the acceleration across the sheet (100 % of it)", {"the acceleration"}),
        (
            jet,
            NOWHERE,
            "it pushes the same way in the room (",
            {"a direction in the room", "how far along y"},
        ),
        (lift, NOWHERE, "it grows with the square of the speed and points the same way", {"the speed either way"}),
        (
            push_near_the_grips,
            NOWHERE,
            "it pushes the same way in the room (74 % of it) and is weaker farther from the grips (26 % of it)",
            {"a direction in the room", "the distance from the grips"},
        ),
    ],
)
def test_a_force_is_told_by_what_it_depends_on_and_every_other_state_is_ruled_out(force, place, words, on):
    said, rows = told(pushed(force), place)
    assert said.startswith(words)
    assert set(rows) == (ALL if place.any() else ALL - {"the place on the cloth"})
    assert {name for name, row in rows.items() if row.depends == "yes"} == on
    assert {name for name, row in rows.items() if row.depends == "no"} == set(rows) - on
    assert ("it is the same on the table and off it" in said) == ("the table" not in on)
    assert said.count("the distance from the grips") == ("the distance from the grips" not in on)


def test_a_push_that_turns_round_with_the_height_points_another_way_higher_up():
    middle = float(np.median(np.concatenate([swung(number).path_m[..., 2].ravel() for number in range(4)])))
    said, rows = told(pushed(lambda one: (one.path_m[..., 2, None] - middle) * X))
    assert said.startswith("it pushes another way higher up (")
    assert rows["the height"].depends == "yes"


def test_what_brakes_reverses_with_the_motion_and_a_push_does_not():
    assert "; all of that reverses with the motion; " in told(pushed(quadratic_drag))[0]
    assert "; none of that reverses with the motion; " in told(pushed(constant_push))[0]
    both = told(pushed(lambda one: quadratic_drag(one) + 1e-3 * X))[0]
    assert "; a part of that reverses with the motion; " in both


@pytest.mark.parametrize("floor", [0.0, 1.0])
def test_noise_alone_shows_no_dependence_whether_its_size_is_known_or_not(floor):
    forces = tuple(replace(one, floor_n=floor * one.floor_n) for one in pushed(nothing, noisy=1.0))
    said, rows = told(forces, PLACE)
    assert said.startswith("no dependence on a state is shown; ")
    assert not {name for name, row in rows.items() if row.depends == "yes"}


def test_chance_passes_the_test_about_as_often_as_its_level_says():
    """A push and a brake, one at a time, set against noise that stretches of half a second hardly share."""
    recordings = [swung(number) for number in range(3)]
    fields = {
        "push": lambda one: np.broadcast_to(X, one.force_n.shape)[None],
        "brake": lambda one: one.velocity_m_s[None],
    }
    for field in fields.values():
        passed = []
        for seed in range(200):
            noisy = tuple(replace(one, force_n=noise(one, 1.0, 10 * seed + k)) for k, one in enumerate(recordings))
            passed.append(Shares.of(noisy, field).chance([], [[0]]))
        assert 0.02 <= np.mean(np.array(passed) <= 0.05) <= 0.09  # 200 trials: 5 % within 3 standard deviations
        assert np.mean(np.array(passed) <= LEVEL) <= 0.03


def test_a_push_along_a_sheet_that_never_turns_is_not_told_from_one_in_the_room():
    forces = pushed(constant_push)
    facing = tuple(
        replace(
            one, states=replace(one.states, normal=np.broadcast_to(constant_push(one), one.force_n.shape) / 1.118e-3)
        )
        for one in forces
    )
    said, rows = told(facing)
    assert {rows[name].depends for name in ("a direction in the room", "the sheet's normal")} == {"undecided"}
    assert "a direction in the room" in said.split("would explain as much")[0]
    assert "the sheet's normal" in said.split("would explain as much")[0]


def test_recordings_of_a_few_stretches_show_nothing():
    said, rows = told(pushed(quadratic_drag, motions=1, duration_s=2.0))
    assert said.startswith("no dependence on a state is shown; ")
    assert rows[SPEED].depends == "undecided"
    assert "it is open whether it depends on" in said


def between_both_drags(one):
    through = across(one, one.velocity_m_s)
    return -1e-3 * (1.0 + 0.75 * np.linalg.norm(through, axis=-1, keepdims=True)) * through


def test_a_power_between_those_that_are_asked_is_left_open():
    said, rows = told(pushed(between_both_drags))
    assert rows[SPEED].depends == "yes"
    assert "brakes with the speed across the sheet, to a power that is open" in said


def test_without_a_table_and_without_grips_neither_is_spoken_of():
    forces = tuple(
        replace(one, table_z_m=None, states=replace(one.states, grip_m=np.full(one.force_n.shape[:2], np.inf)))
        for one in pushed(quadratic_drag)
    )
    said, rows = told(forces)
    assert "table" not in said
    assert set(rows) == ALL - {"the table", "the distance from the grips", "the place on the cloth"}


def test_the_same_forces_are_told_in_the_same_words():
    forces = pushed(curl, noisy=2.0)
    assert told(forces) == told(forces)


def test_no_module_that_decides_on_a_name_reads_what_the_force_depends_on():
    """It is found when the verdict stands (`diagnose.py`), for files and pages."""
    parts = {"assimilate", "dependence", "missing_force", "shares", "state", "state_fields", "state_words"}
    telling = {
        "assimilate",
        "dependence",
        "diagnose",
        "finding_pictures",
        "findings",
        "forces_file",
        "report",
        "shares",
        "state",
        "state_fields",
        "state_words",
    }
    reads = re.compile(rf"sim1\.mismatch\.({'|'.join(parts)})\b|\.located\b|\.signature\b")
    paths = (REPOSITORY / "sim1" / "mismatch").glob("*.py")
    assert {path.stem for path in paths if reads.search(path.read_text())} == telling
    diagnosis = (REPOSITORY / "sim1" / "mismatch" / "diagnose.py").read_text()
    assert diagnosis.index("verdict = ") < diagnosis.index("located = locate_forces(")
