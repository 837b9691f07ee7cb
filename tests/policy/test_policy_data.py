import numpy as np
import pandas as pd
import pytest
from made_up_dataset import toy_trajectory

from sim1.policy.episodes import read_trajectories
from sim1.policy.split import nested_order, split_garment, usable_sizes
from sim1.stage import BadInput, random_stream


def test_each_trajectory_is_read_once_and_in_order_of_its_frames(dataset, trajectories):
    read = read_trajectories(dataset.path)
    assert [(item.garment, item.name) for item in read] == sorted((item.garment, item.name) for item in trajectories)
    by_name = {(item.garment, item.name): item for item in trajectories}
    for item in read:
        truth = by_name[item.garment, item.name]
        np.testing.assert_array_equal(item.action, truth.action)
        np.testing.assert_array_equal(item.keypoints, truth.keypoints)
        assert item.sources == truth.sources


def test_a_dataset_without_tables_is_named(tmp_path):
    with pytest.raises(BadInput, match="no parquet file"):
        read_trajectories(tmp_path)


def test_an_episode_without_provenance_is_named(dataset):
    dataset.provenance().iloc[1:].to_parquet(dataset.path / "provenance.parquet")
    with pytest.raises(BadInput, match=r"episodes \[0\]"):
        read_trajectories(dataset.path)


def test_a_value_that_is_not_finite_is_named(dataset):
    path = dataset.path / "lerobot" / "data" / "chunk-000" / "file-000.parquet"
    table = pd.read_parquet(path)
    table.at[3, "action"] = np.full(14, np.nan, dtype=np.float32)
    table.to_parquet(path)
    with pytest.raises(BadInput, match="episode 0 has values in action"):
        read_trajectories(dataset.path)


def test_a_damaged_table_is_named(dataset):
    path = dataset.path / "lerobot" / "data" / "chunk-000" / "file-000.parquet"
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(BadInput, match="not a readable dataset"):
        read_trajectories(dataset.path)


def test_nothing_of_the_held_out_demonstration_is_in_training(trajectories):
    towels = [item for item in trajectories if item.garment == "towel"]
    split = split_garment(towels, 0.3, random_stream(0))
    assert split.kind == "source"
    assert split.held_out_sources == ("0002",)  # used by 2 of 5, the others by 3 of 5
    assert all("0002" in item.sources for item in split.test)
    assert all("0002" not in item.sources for item in split.train)
    assert len(split.train) + len(split.test) == len(towels)


def alone(count):
    """Trajectories of a demonstration each."""
    return [toy_trajectory("towel", f"{place:04d}", {f"{place:04d}"}, seed=place) for place in range(count)]


@pytest.mark.parametrize(
    ("count", "share", "held_out"), [(24, 0.25, 6), (200, 0.25, 50), (4, 0.25, 1), (3, 0.9, 2), (2, 0.1, 1)]
)
def test_as_many_demonstrations_are_held_out_as_bring_their_share_nearest_and_never_all(count, share, held_out):
    split = split_garment(alone(count), share, random_stream(0))
    assert split.kind == "source"
    assert len(split.held_out_sources) == len(split.test) == held_out
    assert len(split.train) == count - held_out
    assert {source for item in split.test for source in item.sources} == set(split.held_out_sources)
    again = split_garment(alone(count), share, random_stream(1))
    assert again.held_out_sources == split.held_out_sources


def test_a_further_demonstration_that_overshoots_by_more_is_not_held_out():
    """Of twelve trajectories, four are of each demonstration: four are nearer to five than eight."""
    shared = [toy_trajectory("towel", f"{place:04d}", {f"{place % 3:04d}"}, seed=place) for place in range(12)]
    assert split_garment(shared, 5 / 12, random_stream(0)).held_out_sources == ("0000",)
    assert split_garment(shared, 7 / 12, random_stream(0)).held_out_sources == ("0000", "0001")


def test_a_source_that_all_use_cannot_be_held_out_and_the_split_says_so(trajectories):
    mixed = [item for item in trajectories if item.sources == {"0000", "0001"}]
    split = split_garment(mixed, 0.3, random_stream(0))
    assert split.kind == "trajectory"
    assert split.train
    assert split.test
    assert not {item.name + item.garment for item in split.train} & {item.name + item.garment for item in split.test}


def test_a_lone_trajectory_trains_and_tests_nothing(trajectories):
    split = split_garment(trajectories[:1], 0.3, random_stream(0))
    assert (len(split.train), len(split.test), split.kind) == (1, 0, "none")


def test_garments_take_turns_in_training_sets_while_their_trajectories_last(trajectories):
    order = nested_order(trajectories, random_stream(0))
    assert {(item.garment, item.name) for item in order} == {(item.garment, item.name) for item in trajectories}
    for size in (2, 4, 6):
        assert sum(item.garment == "towel" for item in order[:size]) == size // 2
    few_shirts = [item for item in trajectories if item.garment == "towel" or item.name == "0000"]
    garments = [item.garment for item in nested_order(few_shirts, random_stream(0))]
    assert garments == ["towel", "tshirt", "towel", "towel", "towel", "towel"]


def test_sizes_beyond_what_there_is_become_all_there_is():
    assert usable_sizes((2, 4, 8, 16), 6) == [2, 4, 6]
    assert usable_sizes((2, 4, 8, 16), 9) == [2, 4, 9]
    assert usable_sizes((2, 4, 8), 9) == [2, 4, 8]
    assert usable_sizes((2, 4), 1) == [1]
    assert usable_sizes((2, 4), 0) == []


def test_sizes_below_the_number_of_garments_become_one_trajectory_of_each():
    assert usable_sizes((1, 2, 4, 8), 12, garment_count=4) == [4, 8]
    assert usable_sizes((1, 2), 12, garment_count=3) == [3]
    assert usable_sizes((1, 2), 4, garment_count=4) == [4]
    assert usable_sizes((0,), 4, garment_count=4) == []
