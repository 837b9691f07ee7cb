"""The shape from which a simulation starts, as the first markers tell it."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from small_bundle import SIDE_M, empty_bundle, plain_world

from sim1.cloth.precise.arrays import RETAINED, YIELD
from sim1.cloth.precise.bending import turned_by
from sim1.cloth.precise.memory import fold
from sim1.cloth.precise.mesh import square_sheet
from sim1.cloth.precise.scene import prepare
from sim1.cloth.precise.simulate import NotConverged, simulate
from sim1.cloth.precise.start import spread_over
from sim1.stage import BadInput

HANGING = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])  # (u, v) to (x, y, z)


@pytest.fixture(scope="module")
def bundle():
    return empty_bundle(duration_s=1.2, motions=1)


def seen_as(recording, seen):
    """The recording with markers hidden where `seen` (N, M) is false."""
    return replace(recording, markers_m=np.where(seen[..., None], recording.markers_m, np.nan))


@pytest.mark.parametrize("count", [3, 4, 5, 6, 16])
def test_few_markers_tell_where_a_flat_sheet_hangs(count):
    stream = np.random.default_rng(count)
    points, at = stream.uniform(0.0, SIDE_M, (count, 2)), square_sheet(4, SIDE_M).material_m
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = spread_over(points, points @ HANGING + 1e-4 * stream.standard_normal((count, 3)), at, "here:")
    assert np.abs(found - at @ HANGING).max() < 2e-3


def test_a_marker_that_is_not_seen_says_nothing():
    points = np.random.default_rng(0).uniform(0.0, SIDE_M, (6, 2))
    values = points @ HANGING
    values[2] = np.nan
    np.testing.assert_allclose(spread_over(points, values, points, "here:"), points @ HANGING, atol=1e-6)


@pytest.mark.parametrize("count", [3, 6])
def test_markers_on_one_line_are_refused(count):
    points = np.column_stack([np.linspace(0.0, SIDE_M, count), np.full(count, 0.1)])
    with pytest.raises(BadInput, match=rf"^here: the {count} markers that are seen lie on one line"):
        spread_over(points, points @ HANGING, points, "here:")


def test_a_recording_whose_markers_are_hidden_while_it_rests_is_named(bundle):
    recording = bundle.recordings[0]
    seen = np.ones(recording.seen.shape, bool)
    seen[recording.time_s < 0.7] = False
    words = r"^recordings/swing_0/markers\.parquet: at rest, until 0\.5\d\d s, 0 of 16 markers are seen; 3 or more .* begin the"
    with pytest.raises(BadInput, match=words):
        prepare(bundle, seen_as(recording, seen), 1 / 60)


def test_a_recording_whose_markers_are_hidden_as_it_starts_in_motion_is_named(bundle):
    recording = replace(bundle.recordings[0], starts="moving")
    seen = np.ones(recording.seen.shape, bool)
    seen[:5, 2:] = False
    words = (
        r"^recordings/swing_0/markers\.parquet: in 4 or more of the first 7 frames 2 of 16 markers are seen; 3 or more"
    )
    with pytest.raises(BadInput, match=words):
        prepare(bundle, seen_as(recording, seen), 1 / 60)


@pytest.mark.parametrize("rate_hz", [20, 60])
def test_shape_and_velocity_of_a_start_in_motion_come_from_the_first_frames(bundle, rate_hz):
    recording = bundle.recordings[0]
    time = np.arange(0.0, 1.0, 1 / rate_hz)
    velocity = np.array([0.3, -0.1, 0.2])
    markers = recording.markers_m[0] + velocity * time[:, None, None]
    scene = prepare(bundle, replace(recording, starts="moving", time_s=time, markers_m=markers), 1 / 60)
    np.testing.assert_allclose(scene.start_velocity, np.broadcast_to(velocity, scene.start.shape), atol=1e-6)
    np.testing.assert_allclose(scene.start[:, 1], 0.0, atol=1e-6)


def test_where_drives_begin_after_the_markers_the_start_is_that_of_the_first_sample(bundle):
    recording = bundle.recordings[0]
    time, velocity = np.arange(0.0, 1.0, 1 / 60), np.array([0.3, -0.1, 0.2])
    markers = recording.markers_m[0] + velocity * time[:, None, None]
    drives = {name: replace(one, time_s=one.time_s + 0.25) for name, one in recording.drives.items()}
    late = replace(recording, starts="moving", time_s=time, markers_m=markers, drives=drives)
    scene, whole = prepare(bundle, late, 1 / 60), prepare(bundle, replace(late, drives=recording.drives), 1 / 60)
    assert scene.time_s[0] == pytest.approx(0.25)
    np.testing.assert_allclose(
        scene.start - whole.start, np.broadcast_to(0.25 * velocity, scene.start.shape), atol=1e-6
    )
    np.testing.assert_allclose(scene.start_velocity, np.broadcast_to(velocity, scene.start.shape), atol=1e-6)


def test_a_start_in_motion_is_told_in_the_frame_of_the_cameras_and_grips_hold_from_the_first_step(bundle):
    recording = bundle.recordings[0]
    time = np.arange(0.0, 1.0, 1 / 60)
    markers = np.repeat(recording.markers_m[:1], len(time), axis=0)
    scene = prepare(bundle, replace(recording, starts="moving", time_s=time, markers_m=markers), 1 / 60)
    off = replace(plain_world(bundle), frame_shift_m=(0.01, -0.02, 0.005), frame_turn_rad=(0.0, 0.02, 0.01))
    seen = simulate(scene, [off]).markers_m[0]
    np.testing.assert_allclose(
        seen[0][4:], recording.markers_m[0][4:], atol=1e-5
    )  # below the row that moves with what is held
    shape, _ = scene.begun(off)
    run = simulate(scene, [off])
    held = scene.net.held
    np.testing.assert_allclose(run.shapes_m[0][held], scene.paths(off)[0])
    assert np.abs(np.delete(run.shapes_m[0] - shape, held, axis=0)).max() == 0.0


def level_scene():
    """A sheet held out level by its edge, and still; and its world."""
    bundle = empty_bundle(duration_s=0.6, motions=1)
    (recording,), held = bundle.recordings, np.arange(14)  # two rows: they hold its slope too
    track, material = recording.drives["bar"], bundle.mesh.material_m[held]
    places = np.column_stack([material[:, 0] - SIDE_M / 2, np.zeros(14), -material[:, 1]])
    turn = Rotation.from_euler("x", 60, degrees=True).as_quat(scalar_first=True)
    level = replace(
        track,
        rotation_wxyz=np.tile(turn, (len(track.time_s), 1)),
        position_m=np.tile(track.position_m[:1], (len(track.time_s), 1)),
    )
    hold = replace(recording.holds[0], vertices=held, places_m=places)
    recording = replace(recording, drives={"bar": level}, holds=(hold,))
    bundle = replace(bundle, recordings=(recording,))
    return prepare(bundle, recording, 1 / 120), plain_world(bundle)


@pytest.mark.parametrize("memory", [{"hysteresis_n": 2e-4, "turn_1_m": 3.0}, {"yield_1_m": 4.0, "retained": 0.5}])
def test_a_sheet_that_remembers_how_it_was_bent_rests_where_it_starts(memory):
    """Held out level by its edge it sags; what yarns that rub, or folds, keep of that bend is part of its balance."""
    scene, plain = level_scene()
    sags, forgets = simulate(scene, [replace(plain, **memory)]), simulate(scene, [plain])
    assert np.abs(sags.rest_m - forgets.rest_m).max() > 5e-4
    assert np.abs(sags.shapes_m - sags.rest_m).max() < 1e-4


@pytest.mark.parametrize("start", [0.0, 1.0, -1.4])
def test_yarns_that_rub_turn_as_far_in_one_step_as_in_many(start):
    """As a sheet is bent into its rest from flat at once."""
    turn, change, many = 1.5, 4.0, start
    for _ in range(1000):
        many = turned_by(many, change / 1000, turn)
    assert turned_by(start, change, turn) == pytest.approx(many)
    assert turned_by(0.0, 1e-7, turn) == pytest.approx(1e-7, rel=1e-6)
    assert turned_by(start, -100.0, turn) == pytest.approx(-turn)


def test_a_fold_keeps_its_share_and_is_harder_to_bend_back():
    kept, scalar, crease = 0.4, np.zeros(40), np.zeros((1, 6))
    scalar[RETAINED], scalar[YIELD] = kept, 10.0

    def bend(to):
        fold(np.full((1, 3), float(to)), scalar, crease)
        return crease[0, 0]

    assert bend(9.0) == 0.0
    assert bend(30.0) == pytest.approx(kept * 20.0)
    assert bend(0.0) == pytest.approx(kept * 20.0)  # 8 from its rest: within the yield
    assert bend(-10.0) == pytest.approx(kept * 20.0)  # 18 from it, and 10 + 12 are asked by now
    back = bend(-20.0)  # 6 beyond that
    assert back == pytest.approx(kept * (20.0 - 6.0))
    assert bend(-20.0) == pytest.approx(back)


def test_a_sheet_that_is_all_plastic_ends_up_hanging():
    """What folds keep all of, gravity bends on, until nothing is left that bends."""
    scene, plain = level_scene()
    rest = simulate(scene, [replace(plain, yield_1_m=0.5, retained=1.0)]).rest_m
    assert rest[-1, 2] < simulate(scene, [plain]).rest_m[-1, 2] - 2e-3


def test_a_sheet_whose_folds_have_not_settled_is_not_called_at_rest(monkeypatch):
    monkeypatch.setattr("sim1.cloth.precise.rest.FOLDINGS", 1)
    scene, plain = level_scene()
    with pytest.raises(NotConverged, match="swing_0: the sheet finds no rest"):
        simulate(scene, [replace(plain, yield_1_m=0.5, retained=0.5)])
