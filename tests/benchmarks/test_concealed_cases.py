"""What there is to conceal, and which motions a case films."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.concealed.case import Case, plans
from benchmarks.concealed.effects.library import LIBRARY
from benchmarks.concealed.motions import FREE_MOTIONS, HANG, MOTIONS, TABLE_MOTIONS
from benchmarks.concealed.setting import draw_setting

NAMES = {
    "air_drag": "c_normal c_tangential",
    "wind": "vx vy vz",
    "added_mass": "mass",
    "anisotropic_stretch": "ratio_warp_weft",
    "anisotropic_bending": "ratio_warp_weft",
    "strain_stiffening": "growth",
    "bending_hysteresis": "moment",
    "plastic_crease": "yield_curvature retained",
    "rest_curvature": "kappa_u kappa_v",
    "shrinkage": "scale_u scale_v",
    "stiff_region": "centre_u centre_v radius factor",
    "heavy_region": "centre_u centre_v mass",
    "static_friction": "ratio",
    "anisotropic_friction": "mu_x mu_y",
    "adhesion": "pressure",
    "grip_slip": "threshold rate",
    "grip_compliance": "stiffness",
    "actuator_lag": "time_constant",
    "clock_offset": "offset",
    "frame_offset": "tx ty tz rx ry rz",
    "gravity_tilt": "tilt_x tilt_y",
}
"""The format's table."""

PAIRS = (("grip_slip", "grip_compliance"), ("air_drag", "static_friction"), ("anisotropic_friction", "adhesion"))


def test_the_table_of_the_format_is_there_with_its_parameters_and_more_besides():
    setting = draw_setting(np.random.default_rng(0))
    for name, recipe in LIBRARY.items():
        effects = [
            recipe.draw(a, np.random.default_rng(1), setting) for a in (*recipe.amplitudes, recipe.amplitudes[0])
        ]
        assert effects[0].parameters == effects[2].parameters
        assert effects[0].extras == effects[2].extras == effects[1].extras, "places do not depend on the amplitude"
        assert effects[0].parameters != effects[1].parameters
        assert all(isinstance(value, float) and np.isfinite(value) for value in effects[0].parameters.values())
        assert effects[0].name == name
        assert effects[0].formula
        assert set(recipe.shown_by) <= set(MOTIONS)
        assert recipe.in_table == (name in NAMES)
        if name in NAMES:
            assert list(effects[0].parameters) == NAMES[name].split()
    assert sum(not recipe.in_table for recipe in LIBRARY.values()) >= 8


def test_each_case_films_five_motions_that_show_its_effect_and_two_more():
    for name in (*LIBRARY, ""):
        for seed in range(3):
            case = Case((name,) if name else (), "medium", seed)
            found = plans(case, case.setting())
            motions = [plan.motion.name for plan in found if not plan.held_out]
            assert len(set(motions)) == 5
            assert len({plan.name for plan in found}) == 7
            if name:
                assert sum(plan.shown for plan in found if not plan.held_out) >= 3
                assert found[5].shown
    pair = Case(("air_drag", "static_friction"), "medium", 1)
    shown = [plan.motion.name for plan in plans(pair, pair.setting()) if not plan.held_out]
    for effect in pair.effects:
        assert len(set(shown) & set(LIBRARY[effect].shown_by)) >= 2
    assert set(FREE_MOTIONS) < set(MOTIONS)


def filmed(effects: tuple[str, ...], seeds: range) -> list[list[str]]:
    """Names of the motions of each seed's bundle."""
    cases = [Case(effects, "medium", seed) for seed in seeds]
    return [[plan.motion.name for plan in plans(case, case.setting()) if not plan.held_out] for case in cases]


FREE = [name for name, recipe in LIBRARY.items() if not set(recipe.shown_by) & set(TABLE_MOTIONS)]


def tables(bundles: list[list[str]]) -> list[int]:
    """How many motions of each bundle have a table."""
    return [len(set(names) & set(TABLE_MOTIONS)) for names in bundles]


def test_half_of_the_bundles_have_a_table_whatever_is_concealed_that_needs_none():
    """Else whoever sees a table, or none, would know something of the answer. 4.4 standard errors of a fair coin are allowed."""
    nothing = tables(filmed((), range(300)))
    something = [number for name in FREE for number in tables(filmed((name,), range(12)))]
    assert len(FREE) > 20
    for counts in (nothing, something):
        assert np.mean(np.array(counts) > 0) == pytest.approx(0.5, abs=4.4 * 0.5 / np.sqrt(len(counts)))
    assert max(something) == 2
    assert np.mean(np.array(nothing) > 2) > 0.01, "nothing concealed is also filmed as what needs a table is"


def test_what_is_filmed_beside_an_effect_of_the_table_has_a_table_half_the_time_too():
    more = [number > 3 for number in tables(filmed(("adhesion",), range(150)))]
    assert np.mean(more) == pytest.approx(0.5, abs=4.4 * 0.5 / np.sqrt(len(more)))


def test_a_sheet_that_hangs_still_is_filmed_beside_others_and_is_no_motion_to_foretell():
    found = [plans(case, case.setting()) for case in (Case(("air_drag",), "medium", seed) for seed in range(60))]
    names = [[(plan.motion.name, plan.held_out) for plan in some] for some in found]
    assert any((HANG, False) in some for some in names)
    assert not any((HANG, True) in some for some in names)
    assert not any(HANG in recipe.shown_by for recipe in LIBRARY.values())
    motion = next(plan.motion for some in found for plan in some if plan.motion.name == HANG)
    shift, turn = motion.course(np.array([0.0, 0.5, 1.1, 2.0, 4.0]))
    assert shift[1] == pytest.approx(shift[0], abs=1e-12)
    assert shift[0, :, 2] - shift[2, :, 2] == pytest.approx(0.006, rel=0.2)
    assert shift[2:] == pytest.approx(np.broadcast_to(shift[2], shift[2:].shape), abs=1e-12)
    assert turn == pytest.approx(np.broadcast_to(turn[0], turn.shape))


@pytest.mark.parametrize("effects", [(), *((name,) for name in LIBRARY), *PAIRS], ids="+".join)
def test_motions_that_no_diagnosis_is_given_are_others_and_can_be_foretold_from_what_it_is(effects):
    for seed in range(6):
        case = Case(effects, "medium", seed)
        found = plans(case, case.setting())
        filmed, (first, second) = found[:5], found[5:]
        assert first.held_out
        assert second.held_out
        assert len({plan.motion.name for plan in found}) == 7, (
            "none is a filmed one, or the other one, with other amplitudes"
        )
        assert first.motion.name in {name for effect in effects for name in LIBRARY[effect].shown_by} or not effects
        for unseen in (first, second):
            assert set(unseen.motion.blocks) <= {block for plan in filmed for block in plan.motion.blocks}
            assert not unseen.motion.table or any(plan.motion.table for plan in filmed)


def test_an_effect_that_only_a_grip_of_its_own_shows_leaves_nothing_to_foretell(monkeypatch):
    monkeypatch.setitem(LIBRARY, "adhesion", replace(LIBRARY["adhesion"], shown_by=("trail",)))
    case = Case(("adhesion",), "medium", 0)
    with pytest.raises(
        ValueError, match=r"adhesion_0: 200 draws of 5 motions left no 2 others .* add to the motions that do .*: trail"
    ):
        plans(case, case.setting())


def test_chosen_motions_are_filmed_in_their_order_and_no_other():
    case = Case(("air_drag",), "medium", 3, ("bar_tilt", "fast_swing"))
    found = plans(case, case.setting())
    assert [plan.motion.name for plan in found] == ["bar_tilt", "fast_swing"]
    assert [plan.shown for plan in found] == [False, True]
    assert not any(plan.held_out for plan in found)
    with pytest.raises(ValueError, match="no motion 'sway': choose from"):
        Case((), "medium", 3, ("sway",))
