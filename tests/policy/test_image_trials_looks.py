"""What trials of an image policy look like: one look of training for all shifts, one thing changed at a time."""

from dataclasses import fields, replace
from functools import partial

import numpy as np
import pytest
from towel_cell import LOOKS

from sim1.policy.image_trials.looks import SHIFTS, Wardrobe, dress
from sim1.policy.lessons import GENERATED, ModelKey
from sim1.policy.trials import Trial
from sim1.render.looks.draw import draw_appearance, read_looks
from sim1.render.stage import RenderConfig
from sim1.stage import random_stream


@pytest.fixture(scope="module")
def known():
    return read_looks(LOOKS)


@pytest.fixture(scope="module")
def wardrobe(known):
    """Three looks of training."""
    clips = {}
    for place in range(3):
        look = draw_appearance(
            partial(random_stream, place),
            known,
            scanned=np.array([[0.8, 0.2, 0.2]]),
            scanned_share=0.0,
            elevation_jitter_rad=0.05,
        )
        clips[f"000{place}_v0"] = {"appearance": look.to_json(), "stride": 6}
    return Wardrobe(clips=clips, task="fold the towel", config=RenderConfig(elevation_jitter_deg=4.0))


@pytest.fixture(scope="module")
def dressed(known, wardrobe):
    """Function that gives the look of a trial."""

    def of(shift: str, number: int, seed: int = 0, network: int = 0):
        trial = Trial(model=ModelKey(GENERATED, 3, network), garment="towel", shift=shift, number=number)
        return dress(trial, wardrobe, known, seed=seed, viewpoint_rad=np.radians(5.0), frame_count=9)

    return of


def changed(before, after) -> set[str]:
    return {field.name for field in fields(before) if getattr(before, field.name) != getattr(after, field.name)}


def test_all_shifts_of_a_trial_begin_in_one_look_of_training_and_change_what_they_are_called_after(dressed, wardrobe):
    looks = {shift: dressed(shift, 4) for shift in SHIFTS}
    (base,) = {look.trained_look for look in looks.values()}
    assert looks["in-domain"].clip.appearance.to_json() == wardrobe.clips[base]["appearance"]
    plain = looks["in-domain"].clip.appearance
    assert {shift: changed(plain, look.clip.appearance) for shift, look in looks.items()} == {
        "in-domain": set(),
        "spatial": set(),
        "texture": {"fabric", "table"},
        "lighting": {"room"},
        "viewpoint": {"elevation_offset_rad"},
    }


def test_pictures_of_all_shifts_of_a_trial_have_the_same_noise_and_those_of_another_have_others(dressed):
    assert len({dressed(shift, 4).clip.episode for shift in SHIFTS}) == 1  # what the noise is drawn from
    assert len({dressed(shift, 4).clip.key for shift in SHIFTS}) == len(SHIFTS)
    assert dressed("in-domain", 4).clip.episode != dressed("in-domain", 5).clip.episode


def test_trials_of_two_networks_have_looks_noise_and_clips_of_their_own(dressed):
    pairs = [(dressed("in-domain", number), dressed("in-domain", number, network=1)) for number in range(20)]
    assert any(one.trained_look != other.trained_look for one, other in pairs)
    assert all(one.clip.key != other.clip.key and one.clip.episode != other.clip.episode for one, other in pairs)


def test_the_camera_stands_lower_and_higher_in_turn_beyond_what_training_has_seen(dressed):
    assert [dressed("viewpoint", number).columns["elevation_deg"] for number in range(3)] == [-9.0, 9.0, -9.0]


def test_every_look_of_training_is_met_and_the_seed_decides(dressed, wardrobe):
    met = [dressed("in-domain", number).trained_look for number in range(20)]
    assert set(met) == set(wardrobe.clips)
    assert met == [dressed("lighting", number).trained_look for number in range(20)]
    assert met != [dressed("in-domain", number, seed=1).trained_look for number in range(20)]


def test_the_row_says_what_was_seen(dressed):
    look = dressed("lighting", 2)
    columns = look.columns
    assert columns["light"] == columns["room"].split("-")[1]
    assert (columns["fabric"], columns["table"]) == (look.clip.appearance.fabric.name, look.clip.appearance.table.name)
    assert columns == replace(look).columns


def test_a_look_that_trajectories_share_is_counted_once(wardrobe):
    shared = {f"{name}_again": record for name, record in wardrobe.clips.items()}
    assert replace(wardrobe, clips={**wardrobe.clips, **shared}).look_count == wardrobe.look_count == 3
