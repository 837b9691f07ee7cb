"""The stage with a painted camera over a cell that cannot fail: what it leaves behind, that it goes on after a kill, what its check sees."""

import json
import shutil
from dataclasses import replace
from itertools import product
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import torch
from made_up_cell import ObedientCell, failed
from painted_trials import PaintedCamera, bench
from painted_world import HELD_OUT, Painter, write_mite, write_world

import sim1.policy.image_trials.crew
from sim1.film_strip import write_strip
from sim1.policy import paper
from sim1.policy.claims.page import HEADING
from sim1.policy.claims.verdict import NOT_RUN
from sim1.policy.image.build import load
from sim1.policy.image.stage import ImagePolicyConfig, image_policy
from sim1.policy.image_trials.looks import SHIFTS
from sim1.policy.image_trials.measures import read_result
from sim1.policy.image_trials.stage import ImageTrialsConfig, check_image_trials, image_trials
from sim1.policy.results_page import results
from sim1.policy.time_limit import TimeLimit
from sim1.policy.trials import BROKEN
from sim1.stage import BadInput

pytestmark = pytest.mark.filterwarnings("ignore")  # of torch and torchvision, not of this project
CONFIG = ImageTrialsConfig(trial_count=2, processes=1, device="cpu")


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """A towel's dataset, and a very small policy that was trained on it."""
    folder = tmp_path_factory.mktemp("world")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sim1.render.blender.run_blender", Painter())
        made = write_world(folder)
    (folder / "policy").mkdir()
    learning = ImagePolicyConfig(
        policy="mite", seeds=(3, 5), steps=1, batch=2, chunk_s=0.5, device="cpu", processes=1, shifted_trajectories=0
    )
    image_policy({**made, **write_mite(folder / "policies")}, folder / "policy", learning)
    return {**made, "image_policy": {"": folder / "policy"}}


@pytest.fixture(scope="module")
def world(inputs):
    """Function that runs the stage."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sim1.policy.image_trials.crew, "LiveCamera", PaintedCamera)
        patch.setattr(sim1.policy.image_trials.crew, "open_bench", lambda inputs, garment, world, factor: bench(factor))

        def run(out: Path, config: ImageTrialsConfig = CONFIG, **others):
            out.mkdir(exist_ok=True)
            return image_trials({**inputs, **others}, out, config)

        yield run


@pytest.fixture(scope="module")
def made(world, tmp_path_factory):
    out = tmp_path_factory.mktemp("made") / "out"
    return out, world(out)


@pytest.fixture
def artifact(made, tmp_path) -> Path:
    """A copy to be damaged."""
    return Path(shutil.copytree(made[0], tmp_path / "artifact"))


def table(out: Path) -> pd.DataFrame:
    return pd.read_parquet(out / "trials.parquet")


def test_every_shift_is_tried_and_counted_and_nothing_else_is_left_behind(made):
    out, facts = made
    assert failed(check_image_trials(out)) == []
    assert table(out)["shift"].value_counts().to_dict() == dict.fromkeys(SHIFTS, 4)  # of two networks
    assert (facts["trial_count"], facts["success_count"], facts["trials_in"]) == (20, 16, "stand-in reality")
    assert facts["network_count"] == 2
    assert "no robot" in facts["stand_in"]
    names = {"image_trials.json", "trials.parquet", "facts.json", "report.html", "success.png"}
    assert {path.name for path in out.iterdir()} == names | {f"trials_{shift}.png" for shift in SHIFTS}


def test_trials_of_one_number_meet_one_placement_and_the_moved_one_lies_in_the_same_direction(made):
    trials = table(made[0]).set_index(["shift", "seed", "trial"])
    for seed, number in product((3, 5), (0, 1)):
        rows = {shift: trials.loc[shift, seed, number] for shift in SHIFTS}
        places = {shift: np.array([row["shift_x_m"], row["shift_y_m"]]) for shift, row in rows.items()}
        for shift in ("texture", "lighting", "viewpoint"):
            np.testing.assert_array_equal(places[shift], places["in-domain"])
        np.testing.assert_allclose(places["spatial"], 8 * places["in-domain"], atol=1e-9)  # of 8 cm in place of 1 cm
        assert abs(rows["spatial"]["turn_rad"]) <= np.radians(15)
    assert table(made[0])[table(made[0])["shift"] == "in-domain"]["shift_x_m"].nunique() == 4  # networks have their own


def test_every_network_drives_itself(made, world, inputs, tmp_path, monkeypatch):
    loaded = []
    monkeypatch.setattr(
        sim1.policy.image_trials.crew, "load", lambda path, device: (loaded.append(path.name), load(path, device))[1]
    )
    world(tmp_path / "out", replace(CONFIG, shifts=("in-domain",), trial_count=1))
    assert loaded == ["3", "5"]  # one after the other
    assert table(tmp_path / "out")["seed"].tolist() == [3, 5]


def test_another_texture_has_another_friction_in_turn_and_no_other_shift_has(made):
    trials = table(made[0])
    texture = trials["shift"] == "texture"
    assert trials["friction_factor"][texture].tolist() == [0.6, 1.6, 0.6, 1.6]
    assert set(trials["friction_factor"][~texture]) == {1.0}


def test_looks_are_those_of_training_and_never_of_what_was_held_out(world, tmp_path):
    world(tmp_path / "out", replace(CONFIG, trial_count=12, shifts=("in-domain",), time_factor=0.3))
    met = set(table(tmp_path / "out")["trained_look"])
    assert len(met) > 2
    assert not [name for name in met if name.startswith(HELD_OUT)]


def test_a_strip_shows_the_very_pictures_that_the_policy_saw_and_says_in_what(made, world, tmp_path, monkeypatch):
    kept = {}
    monkeypatch.setattr(
        sim1.policy.image_trials.crew,
        "write_strip",
        lambda path, strip: (kept.update({path.parent.name: strip}), write_strip(path, strip)),
    )
    world(tmp_path / "out", replace(CONFIG, shifts=("texture",), trial_count=1))
    strip = next(iter(kept.values()))
    row = table(tmp_path / "out").iloc[0]
    assert strip.title.startswith("towel, network seed 3, trial 0, ")
    assert strip.title.endswith(
        f"{row['fabric']} on {row['table']}, light {row['light']}, camera {row['elevation_deg']:+.0f}°, friction × 0.6"
    )
    frames = [int(np.flatnonzero((picture == 255).all(axis=(0, 2)))[0]) for picture in strip.pictures]
    assert [frame / 10 for frame in frames] == pytest.approx(strip.times_s)
    assert (frames[0], frames[-1]) == (0, row["picture_count"] - 1)


def test_a_killed_run_goes_on_with_the_trials_that_are_made_and_ends_with_the_same_bytes(
    made, world, tmp_path, monkeypatch
):
    out, real, begun = tmp_path / "out", sim1.policy.image_trials.crew.drive, []

    def drive(bench, trial, *rest):
        if len(begun) == 4:
            raise KeyboardInterrupt
        begun.append(trial.name)
        return real(bench, trial, *rest)

    monkeypatch.setattr(sim1.policy.image_trials.crew, "drive", drive)
    with pytest.raises(KeyboardInterrupt):
        world(out)
    first, begun[:] = list(begun), []
    monkeypatch.setattr(
        sim1.policy.image_trials.crew, "drive", lambda b, t, *rest: (begun.append(t.name), real(b, t, *rest))[1]
    )
    for _ in range(2):  # then killed before it is in the store
        assert world(out) == made[1]
    assert (len(first), len(begun)) == (4, 16)
    assert {path.name: path.read_bytes() for path in out.iterdir()} == {
        path.name: path.read_bytes() for path in made[0].iterdir()
    }


def test_a_policy_that_answers_by_chance_has_the_same_luck_in_every_shift_of_a_trial(world, tmp_path, monkeypatch):
    class Guessing:
        policy = SimpleNamespace(
            config=SimpleNamespace(observation_delta_indices=None, image_features={"observation.images.head": None})
        )

        def answer(self, batch):
            return torch.rand(1, 5, 14).numpy()

    def open_bench(*_):
        cell = ObedientCell()
        return replace(bench(1.0), cell=cell, judge=lambda history: (True, None, {"joint": cell.joints_rad[0, 0]}))

    monkeypatch.setattr(sim1.policy.image_trials.crew, "load", lambda *_: Guessing())
    monkeypatch.setattr(sim1.policy.image_trials.crew, "open_bench", open_bench)
    world(tmp_path / "out", replace(CONFIG, shifts=("in-domain", "lighting")))
    luck = table(tmp_path / "out").set_index(["shift", "seed", "trial"])["figures"]
    assert luck["in-domain"].tolist() == luck["lighting"].tolist()
    assert luck["in-domain"].nunique() == 4


def test_a_simulation_that_breaks_is_a_failure_and_its_strip_ends_there(world, tmp_path, monkeypatch):
    monkeypatch.setattr(sim1.policy.image_trials.crew, "open_bench", lambda *_: bench(1.0, breaks_at=5))
    world(tmp_path / "out", replace(CONFIG, shifts=("in-domain",), trial_count=1))
    row = table(tmp_path / "out").iloc[0]
    assert (row["failure"], row["picture_count"]) == (BROKEN, 2)  # frames 0 and 3 of the cell
    assert failed(check_image_trials(tmp_path / "out")) == []


def test_the_time_of_a_trial_is_that_of_stage_policy(made):
    about = json.loads((made[0] / "image_trials.json").read_text())
    longest = TimeLimit(duration_s=1.2 * 9 / 10, longest_of="generated")  # 25 states at 30 Hz are 9 frames at 10 Hz
    assert about["time_limits"]["towel"] == pytest.approx({"duration_s": longest.duration_s, "longest_of": "generated"})


def test_the_page_of_results_has_the_papers_figures_beside_and_what_the_policy_saw(made):
    claims, table_, strips = results({"image_trials": {"": made[0]}}, {})
    assert claims.heading == HEADING
    rows = {row["Shift"]: row for row in table_.table}
    assert list(rows) == [*paper.SHIFTS, paper.AVERAGE]
    assert [row["Success (%) | paper"] for row in rows.values()] == [67, 93, 90, 82, 47, 76]
    assert rows["texture"]["Success (%) | here"].replace("\N{NO-BREAK SPACE}", " ") == "0 (0 to 49), 0 of 4"
    assert rows["texture"]["Change (points)"].replace("\N{NO-BREAK SPACE}", " ") == "-100 (-100 to -31), 4 pairs"
    assert rows["lighting"]["Change (points)"].replace("\N{NO-BREAK SPACE}", " ") == "+0 (-49 to +49), 4 pairs"
    said = " ".join(table_.paragraphs)
    assert "drives (2 networks) in the stand-in reality" in said
    assert "One network alone" not in said
    assert [picture.path.name for picture in strips.pictures] == [f"trials_{shift}.png" for shift in SHIFTS]


def test_a_shift_that_was_not_run_says_so_and_without_trials_nothing_is_shown(world, tmp_path):
    world(tmp_path / "out", replace(CONFIG, trial_count=0))
    assert failed(check_image_trials(tmp_path / "out")) == []
    claims, table_, strips = results({"image_trials": {"": tmp_path / "out"}}, {})
    assert {row["Verdict"] for row in claims.table} == {NOT_RUN}
    assert {row["Success (%) | here"] for row in table_.table} == {"not run"}
    assert strips.pictures == []


DAMAGES = {
    "every_trial_accounted_for": lambda trials: trials.iloc[1:],
    "figures_finite": lambda trials: trials.assign(simulated_s=np.nan),
    "shifts_compare_in_pairs": lambda trials: trials.assign(shift_x_m=np.arange(20.0)),
    "every_plan_saw_a_picture": lambda trials: trials.assign(picture_count=1),
    "figures_follow_from_trials": lambda trials: trials.assign(success=False, failure="slip"),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_the_check_sees_what_is_wrong_with_the_trials(artifact, name):
    DAMAGES[name](table(artifact)).to_parquet(artifact / "trials.parquet")
    assert name in failed(check_image_trials(artifact))


def test_the_check_misses_a_strip_and_a_count_on_the_page(artifact):
    (artifact / "trials_lighting.png").unlink()
    (artifact / "report.html").write_text("<p>stand-in, no robot</p>")
    assert failed(check_image_trials(artifact)) == ["film_strips_present", "page_states_its_counts"]


def test_the_check_sees_a_change_outside_its_interval_and_failures_that_do_not_add_up(artifact):
    about = json.loads((artifact / "image_trials.json").read_text())
    texture = next(one for one in about["tried"] if one["shift"] == "texture")
    texture["change"]["value"], texture["failures"] = 0.5, {"slip": 1}
    (artifact / "image_trials.json").write_text(json.dumps(about))
    assert failed(check_image_trials(artifact)) == ["figures_follow_from_trials", "intervals_hold_their_values"]


def test_an_artifact_of_another_version_is_named(artifact):
    about = json.loads((artifact / "image_trials.json").read_text())
    (artifact / "image_trials.json").write_text(json.dumps({**about, "schema": "sim1.image_trials/0"}))
    with pytest.raises(BadInput, match=r"'sim1\.image_trials/0'.*make image_trials again"):
        read_result(artifact)


def test_a_gpu_that_is_not_there_is_told(world, tmp_path, monkeypatch):
    monkeypatch.setattr("sim1.policy.image_trials.experiment.gpu_memory_gib", lambda: 0.0)
    with pytest.raises(BadInput, match="device of stage image_trials is gpu"):
        world(tmp_path / "out", replace(CONFIG, device="gpu"))
