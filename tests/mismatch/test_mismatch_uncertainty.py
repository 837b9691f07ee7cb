"""Intervals of coefficients, on straight models whose answer is known."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle

from sim1.cloth.effects import EFFECTS
from sim1.cloth.effects.coefficient import Coefficient
from sim1.mismatch.fit import Fit
from sim1.mismatch.search import Term, Unknowns, baseline
from sim1.mismatch.uncertainty import (
    WIDEN,
    deviations,
    established,
    established_along,
    mesh_shift,
    overcounted,
    scatter,
    unsteadiness,
)

NAMES = ("a", "b", "c", "d")
TRUE = np.array([0.7, -0.4])
PRIOR_STD = 100.0  # of z: so wide that it says nothing


@pytest.fixture(scope="module")
def unknowns():
    two = tuple(Coefficient(name=name, unit="1", scale=PRIOR_STD) for name in ("p", "q"))
    return Unknowns(base=baseline(empty_bundle(motions=2)).base, nominal=two)


def fitted(unknowns, stream, off=None, mesh_off=None, samples=100):
    """The least squares fit to four recordings; `off` (4, 2): by how much each one's simulations are wrong, as a shift of z."""
    off = np.zeros((4, 2)) if off is None else off
    slopes = {name: 2.0 * stream.standard_normal((samples, 2)) for name in NAMES}
    noise = {name: 0.01 * stream.standard_normal(samples) for name in NAMES}
    data = {name: slopes[name] @ (TRUE + off[k]) - noise[name] for k, name in enumerate(NAMES)}
    z = np.linalg.lstsq(np.vstack(list(slopes.values())), np.concatenate(list(data.values())), rcond=None)[0]
    return Fit(
        unknowns=unknowns,
        z=z,
        names=NAMES,
        temper=dict.fromkeys(NAMES, 1.0),
        residuals={name: slopes[name] @ z - data[name] for name in NAMES},
        slopes=slopes,
        mesh_off=mesh_off(slopes) if mesh_off else {name: np.zeros(samples) for name in NAMES},
        stretch={name: np.arange(samples) // 10 for name in NAMES},
        converged=True,
    )


def test_recordings_that_agree_leave_laplace_and_its_widening(unknowns):
    found = fitted(unknowns, np.random.default_rng(1))
    assert deviations(found) == pytest.approx(WIDEN * np.sqrt(np.diag(found.covariance)), rel=0.01)


def test_intervals_hold_the_truth_where_every_recording_errs_in_its_own_way(unknowns):
    stream, held, laplace = np.random.default_rng(2), [], []
    for _ in range(300):
        found = fitted(unknowns, stream, off=0.5 * stream.standard_normal((4, 2)))
        off = np.abs(found.z - TRUE)
        held.append(off < 1.96 * deviations(found))
        laplace.append(off < 1.96 * WIDEN * np.sqrt(np.diag(found.covariance)))
    assert np.mean(laplace) < 0.8
    assert 0.9 < np.mean(held) < 0.995


def test_scatter_is_that_of_the_mean_of_what_recordings_would_say_alone(unknowns):
    stream = np.random.default_rng(3)
    off = stream.standard_normal((4, 2))
    found = fitted(unknowns, stream, off=0.1 * off, samples=4000)
    assert scatter(found) == pytest.approx(0.01 * np.cov(off.T) / 4, rel=0.2)


def test_what_the_mesh_is_off_by_widens_the_coefficient_that_it_moves(unknowns):
    moved = np.array([0.0, 0.3])
    found = fitted(
        unknowns, np.random.default_rng(4), mesh_off=lambda slopes: {name: j @ moved for name, j in slopes.items()}
    )
    assert mesh_shift(found) == pytest.approx(-moved, abs=0.01)
    wider = deviations(found) / (WIDEN * np.sqrt(np.diag(found.covariance)))
    assert wider[0] == pytest.approx(1.0, abs=0.02)
    assert wider[1] > 1.3


def test_one_recording_disagrees_with_none(unknowns):
    found = fitted(unknowns, np.random.default_rng(5))
    alone = Fit(**{**vars(found), "names": ("a",)})
    assert np.all(scatter(alone) == 0.0)
    assert np.isfinite(deviations(alone)).all()


def test_an_effect_is_there_where_recordings_agree_on_it_and_not_where_they_pull_it_to_and_fro(unknowns):
    """Four recordings that all want 0.7, and four that want 0.7 in the mean and anything between -3 and 3 by themselves."""
    tilt = replace(Term.of(EFFECTS["gravity_tilt"]), coefficients=unknowns.nominal)
    model = replace(unknowns, nominal=(), terms=(tilt,))
    agreed = replace(fitted(unknowns, np.random.default_rng(4)), unknowns=model)
    apart = np.array([[3.0, -3.0], [-3.0, 3.0], [3.0, 3.0], [-3.0, -3.0]])
    torn = replace(fitted(unknowns, np.random.default_rng(4), off=apart), unknowns=model)
    assert np.abs(torn.z - TRUE).max() < 1.0
    assert established(agreed, 0, 0.05)
    assert not established(torn, 0, 0.05)


def evidence(unknowns, stream, shared, gained=0.3, stretches=40):
    """A model and what it was fitted from, which lacks `gained` times a slope; what is left is unit noise.

    Of that `shared` (a variance) is what a wrong simulator does to all of a stretch of ten along the same slopes.
    """
    found = fitted(unknowns, stream, samples=10 * stretches)
    lacking, left = {}, {}
    for name in NAMES:
        slope = found.slopes[name][:, 0]
        off = np.sqrt(shared) * stream.standard_normal(stretches)
        left[name] = stream.standard_normal(10 * stretches) + slope * off[found.stretch[name]]
        lacking[name] = left[name] + gained * slope
    return replace(found, residuals=left), replace(found, residuals=lacking)


def test_independent_residuals_are_counted_once(unknowns):
    stream = np.random.default_rng(7)
    assert np.mean([overcounted(*evidence(unknowns, stream, 0.0)) for _ in range(20)]) == pytest.approx(1.0, abs=0.25)


def test_an_error_that_all_residuals_of_a_stretch_share_is_counted_once_where_it_looks_like_the_effect(unknowns):
    """Ten residuals with a slope of 2 per stretch: information 40, and an error of variance 1/4 makes them vary 11-fold or more."""
    stream = np.random.default_rng(8)
    found = [overcounted(*evidence(unknowns, stream, 0.25)) for _ in range(20)]
    assert 4.0 < np.mean(found) < 20.0


def test_how_often_an_error_is_counted_does_not_depend_on_how_large_the_gain_is(unknowns):
    little, much = (
        np.mean([overcounted(*evidence(unknowns, np.random.default_rng(k), 0.25, gained)) for k in range(5)])
        for gained in (0.1, 0.2)
    )
    assert little == pytest.approx(much, rel=0.05)


def test_what_differs_from_second_to_second_is_told_in_shares_of_the_effect(unknowns):
    """A formula that is 5 % off in every stretch, however strong the effect; and an effect that is not there."""
    for strength in (1.0, 2.0, 8.0):
        found = [
            unsteadiness(*evidence(unknowns, np.random.default_rng(k), (0.05 * strength) ** 2, strength))
            for k in range(10)
        ]
        assert 0.0 <= np.mean(found) < 0.1
    torn = [unsteadiness(*evidence(unknowns, np.random.default_rng(k), 1.0, 1.0)) for k in range(10)]
    assert 0.5 < np.mean(torn) < 1.2  # robust weights make less of what differs most


def counted_where_the_fit_is(unknowns, shared, stretches):
    """Mean of 300 models along whose slope the residuals pull by nothing in all, as where a fit ends."""
    counted = []
    for k in range(300):
        found, base = evidence(unknowns, np.random.default_rng(k), shared, 1.0, stretches)
        slope = {name: base.residuals[name] - found.residuals[name] for name in NAMES}
        shift = sum((slope[n] * found.residuals[n]).sum() for n in NAMES) / sum((slope[n] ** 2).sum() for n in NAMES)
        there = {n: found.residuals[n] - shift * slope[n] for n in NAMES}
        counted.append(overcounted(replace(found, residuals=there), base))
    return np.mean(counted)


def test_few_stretches_tell_little_and_name_no_error_that_is_not_there(unknowns):
    assert counted_where_the_fit_is(unknowns, 0.0, 1) < 1.3
    few, many = (counted_where_the_fit_is(unknowns, 0.25, stretches) for stretches in (1, 40))
    assert 1.0 + 0.4 * (many - 1.0) < few < many


def test_an_error_across_the_effect_is_no_witness_against_it(unknowns):
    """The simulator errs along the other coefficient's slopes: what it does has nothing in common with what the effect took away."""
    stream, counted = np.random.default_rng(10), []
    for _ in range(20):
        found, base = evidence(unknowns, stream, 0.0)
        wrong = {
            name: (0.5 * stream.standard_normal(40))[found.stretch[name]] * found.slopes[name][:, 1] for name in NAMES
        }
        shifted = [{name: one.residuals[name] + wrong[name] for name in NAMES} for one in (found, base)]
        counted.append(overcounted(replace(found, residuals=shifted[0]), replace(base, residuals=shifted[1])))
    assert np.mean(counted) < 2.5


def test_a_model_that_changes_nothing_counts_nothing_twice(unknowns):
    found, _ = evidence(unknowns, np.random.default_rng(9), 0.25)
    assert overcounted(found, found) == 1.0


def test_a_place_without_a_strength_is_no_effect(unknowns):
    """Shapes say where something acts; they are not tested."""
    strength, place = unknowns.nominal
    tilt = replace(Term.of(EFFECTS["gravity_tilt"]), coefficients=(strength, replace(place, shape=True)))
    found = fitted(unknowns, np.random.default_rng(5))
    nothing = replace(found, unknowns=replace(unknowns, nominal=(), terms=(tilt,)), z=np.array([1e-4, -0.4]))
    assert not established(nothing, 0, 0.05)


def one_strength(unknowns, stream, strength, off):
    """The fit of one strength that recordings (4,) are off by, and the model without it; of which slopes are straight."""
    only = Term.of(EFFECTS["gravity_tilt"])
    only = replace(only, coefficients=unknowns.nominal[:1])
    slopes = {name: 2.0 * stream.standard_normal((200, 1)) for name in NAMES}
    data = {
        name: slopes[name][:, 0] * (strength + off[k]) + stream.standard_normal(200) for k, name in enumerate(NAMES)
    }
    z = np.linalg.lstsq(np.vstack(list(slopes.values())), np.concatenate(list(data.values())), rcond=None)[0]
    parts = {"temper": dict.fromkeys(NAMES, 3.0), "mesh_off": {name: np.zeros(200) for name in NAMES}}
    parts |= {"names": NAMES, "stretch": {name: np.arange(200) // 10 for name in NAMES}, "converged": True}
    found = Fit(
        unknowns=replace(unknowns, nominal=(), terms=(only,)),
        z=z,
        slopes=slopes,
        residuals={name: slopes[name] @ z - data[name] for name in NAMES},
        **parts,
    )
    residuals = {name: -data[name] for name in NAMES}
    base = Fit(
        unknowns=replace(unknowns, nominal=()),
        z=np.zeros(0),
        slopes={name: np.zeros((200, 0)) for name in NAMES},
        residuals=residuals,
        **parts,
    )
    return found, base


def test_of_a_straight_model_the_way_and_the_slopes_say_the_same(unknowns):
    """Strengths from nothing to twice what is there beyond doubt, of recordings that disagree more or less."""
    said = []
    for seed in range(120):
        stream = np.random.default_rng(seed)
        off = stream.uniform(0.0, 0.3) * stream.standard_normal(4)
        found, base = one_strength(unknowns, stream, stream.uniform(0.0, 0.6), off)
        said.append((established(found, 0, 0.05), established_along(found, base, 0.05)))
    slopes, way = np.array(said).T
    assert 0.2 < slopes.mean() < 0.8
    assert (slopes == way).mean() > 0.95


def test_slopes_that_are_wild_at_the_end_of_the_way_hide_no_effect(unknowns):
    """Cloth that sticks: next to nothing of what the strength changed is changed by a little more of it."""
    found, base = one_strength(unknowns, np.random.default_rng(1), 1.0, np.zeros(4))
    wild = replace(found, slopes={name: 1e-3 * slopes for name, slopes in found.slopes.items()})
    assert not established(wild, 0, 0.05)
    assert established_along(wild, base, 0.05)


def test_what_recordings_pull_to_and_fro_is_not_there_along_the_way_either(unknowns):
    found, base = one_strength(unknowns, np.random.default_rng(1), 0.3, np.array([2.0, -2.0, 2.0, -2.0]))
    assert not established_along(found, base, 0.05)


def test_what_another_mesh_would_undo_is_not_there(unknowns):
    found, base = one_strength(unknowns, np.random.default_rng(1), 1.0, np.zeros(4))
    undone = {name: base.residuals[name] - found.residuals[name] for name in NAMES}
    assert established_along(found, base, 0.05)
    assert not established_along(replace(found, mesh_off=undone), base, 0.05)


def test_a_model_that_changes_nothing_is_not_there(unknowns):
    _, base = one_strength(unknowns, np.random.default_rng(1), 1.0, np.zeros(4))
    assert not established_along(base, base, 0.05)
