"""Pictures in which one thing is changed, and which trajectories are shown in them."""

from dataclasses import fields, replace
from functools import partial

import numpy as np
import pandas as pd
import pytest
from opengl import with_opengl
from painted_world import ROBOT
from PIL import Image
from towel_cell import LOOKS, write_inputs

from sim1.dataset.stage import DatasetConfig, dataset
from sim1.policy.episodes import Trajectory, read_trajectories
from sim1.policy.image.clips import Clip, clips_of
from sim1.policy.image.shifts import IN_DOMAIN, TITLES, shifted_looks
from sim1.policy.image.views import choose_trajectories, write_views
from sim1.render.appearance import SCANNED
from sim1.render.looks.draw import draw_appearance, read_looks
from sim1.render.stage import RenderConfig, rendered_episodes
from sim1.stage import BadInput, random_stream

TURN_RAD, JITTER_RAD = np.radians(5.0), np.radians(4.0)


def chance(seed: int):
    return partial(random_stream, seed)


@pytest.fixture(scope="module")
def known():
    return read_looks(LOOKS)


@pytest.fixture
def trained(known):
    return draw_appearance(
        chance(0), known, scanned=np.array([[0.8, 0.2, 0.2]]), scanned_share=1.0, elevation_jitter_rad=JITTER_RAD
    )


def shifted(trained, known, seed: int):
    return shifted_looks(trained, chance(seed), known, viewpoint_rad=TURN_RAD, jitter_rad=JITTER_RAD)


def changed(before, after) -> set[str]:
    return {field.name for field in fields(before) if getattr(before, field.name) != getattr(after, field.name)}


def test_every_shift_changes_one_thing_alone(trained, known):
    looks = shifted(trained, known, 1)
    assert list(looks) == list(TITLES)
    assert {name: changed(trained, look) for name, look in looks.items()} == {
        IN_DOMAIN: set(),
        "lighting": {"room"},
        "viewpoint_down": {"elevation_offset_rad"},
        "viewpoint_up": {"elevation_offset_rad"},
        "texture": {"fabric", "table"},
    }
    assert {"glows", "name"} <= changed(trained.room, looks["lighting"].room) <= {"glows", "lamps", "name"}


def test_the_shifted_viewpoints_lie_beyond_all_that_training_has_seen(trained, known):
    assert trained.elevation_offset_rad != 0.0
    looks = shifted(trained, known, 1)
    offsets = [looks[name].elevation_offset_rad for name in ("viewpoint_down", "viewpoint_up")]
    np.testing.assert_allclose(np.degrees(offsets), [-9.0, 9.0])


def test_other_lighting_is_never_the_trained_one_and_the_room_is_named_by_it(trained, known):
    layout, light, palette = trained.room.name.split("-")
    for seed in range(20):
        room = shifted(trained, known, seed)["lighting"].room
        assert room.name.split("-")[::2] == [layout, palette]
        assert room.name.split("-")[1] != light
        assert room.glows != trained.room.glows


def test_without_another_light_the_files_are_at_fault(trained, known):
    light = trained.room.name.split("-")[1]
    alone = replace(known, rooms=tuple(room for room in known.rooms if room.name.split("-")[1] == light))
    with pytest.raises(BadInput, match=rf"rooms\.yaml: lights has '{light}' alone.*add another"):
        shifted(trained, alone, 0)


def test_another_texture_is_never_the_scanned_one_and_the_same_chance_gives_the_same_looks(trained, known):
    for seed in range(20):
        looks = shifted(trained, known, seed)
        assert looks["texture"].fabric.name != SCANNED
        assert looks == shifted(trained, known, seed)


def still(garment: str, name: str) -> Trajectory:
    nothing = np.zeros((3, 14), np.float32)
    return Trajectory(
        garment=garment, name=name, sources=frozenset({"0000"}), state=nothing, keypoints=nothing, action=nothing
    )


def held_out(*names: str) -> list[Clip]:
    items = [still(*name.split("/")) for name in names]
    return [
        Clip(episode_index=2 * place + appearance, appearance=appearance, trajectory=item)
        for place, item in enumerate(items)
        for appearance in (0, 1)
    ]


@pytest.mark.parametrize(
    ("count", "first", "chosen"),
    [
        (1, ("towel",), ["towel/0"]),
        (3, ("towel",), ["towel/0", "polo/0", "shorts/0"]),
        (9, (), ["polo/0", "shorts/0", "towel/0", "polo/1", "towel/1"]),
        (1, ("sock",), ["polo/0"]),
        (0, ("towel",), []),
    ],
)
def test_garments_take_turns_the_preferred_first_and_each_trajectory_counts_once(count, first, chosen):
    clips = held_out("polo/0", "polo/1", "shorts/0", "towel/0", "towel/1")
    assert [f"{item.garment}/{item.name}" for item in choose_trajectories(clips, count, first)] == chosen


@pytest.fixture(params=["cycles", "workbench"])
def rendered(tmp_path, request):
    """A towel's one trajectory, rendered by Blender, and its dataset."""
    inputs = write_inputs(tmp_path, frame_count=4)
    for name in ("rendered", "dataset", "out"):
        (tmp_path / name).mkdir()
    config = RenderConfig(
        seed=5, engine=request.param, width=48, height=36, samples=1, rate_hz=15, variants=1, threads=1
    )
    with with_opengl():
        rendered_episodes(inputs, tmp_path / "rendered", config)
    dataset(
        {"robot": ROBOT, "rendered_episodes": {"towel": tmp_path / "rendered"}}, tmp_path / "dataset", DatasetConfig()
    )
    return {
        **inputs,
        "rendered_episodes": {"towel": tmp_path / "rendered"},
        "dataset": {"": tmp_path / "dataset"},
    }


@pytest.mark.filterwarnings("ignore")  # of torch and torchvision, not of this project
def test_blender_shows_the_look_of_training_again_to_the_bit_and_the_others_differ(rendered, tmp_path, request):
    data = rendered["dataset"][""]
    trajectories = read_trajectories(data)
    train = clips_of(data, trajectories)
    write_views(rendered, trajectories, train, tmp_path / "out", seed=0, viewpoint_rad=TURN_RAD)

    def picture(folder, variant):
        return np.asarray(Image.open(folder / "episodes" / "0000" / f"v{variant}" / "head" / "000001.png"), float)

    frames = tmp_path / "out" / "frames" / "towel"
    before = picture(rendered["rendered_episodes"]["towel"], 0)
    seen = {name: picture(frames, place) for place, name in enumerate(TITLES)}
    np.testing.assert_array_equal(seen[IN_DOMAIN], before)
    kept = (IN_DOMAIN, "lighting") if request.node.callspec.params["rendered"] == "workbench" else (IN_DOMAIN,)
    for name in set(TITLES) - set(kept):  # the preview knows no light
        assert np.abs(seen[name] - before).mean() > 2.0, name

    views = tmp_path / "out" / "views"
    table = pd.read_parquet(views / "provenance.parquet")
    assert table["appearance"].tolist() == list(range(len(TITLES)))
    again = clips_of(views, trajectories)
    assert [clip.trajectory.name for clip in again] == ["0000"] * len(TITLES)
    np.testing.assert_array_equal(read_trajectories(views)[0].action, trajectories[0].action)


def test_a_record_of_another_schema_is_named(tmp_path):
    about = tmp_path / "rendered/episodes/0/v0/appearance.json"
    about.parent.mkdir(parents=True)
    about.write_text('{"schema": "sim1.appearance/1"}')
    clips = held_out("towel/0")
    inputs = {name: {"towel": tmp_path / "rendered"} for name in ("rendered_episodes", "garment_mesh", "scene")}
    with pytest.raises(BadInput, match=r"appearance\.json: .*'sim1\.appearance/1', expected 'sim1\.appearance/3'"):
        write_views(
            {"dataset": {"": tmp_path}, **inputs},
            [clips[0].trajectory],
            clips,
            tmp_path,
            seed=0,
            viewpoint_rad=0.1,
        )


def test_a_garment_that_was_not_rendered_is_named(tmp_path):
    clips = held_out("towel/0")
    with pytest.raises(BadInput, match="'rendered_episodes': none for garment 'towel'; materialize it first"):
        write_views({"dataset": {"": tmp_path}}, [clips[0].trajectory], clips, tmp_path, seed=0, viewpoint_rad=0.1)
