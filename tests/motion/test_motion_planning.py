import json
from dataclasses import replace

import numpy as np
import pytest
from motion_synthetic import BASES, HOME, URDF, a_model, speed_shares

from sim1.episode import ARMS, Episode, write_episode
from sim1.motion import joining
from sim1.motion.commands import FREE
from sim1.motion.joining import Variation, drawn
from sim1.motion.likeness.paths import demonstrated as paths_of
from sim1.motion.likeness.paths import planned_paths
from sim1.motion.model import transition, write_model
from sim1.motion.planning import NoPlan, laid_as_placed, planned
from sim1.motion.pool import write_pool
from sim1.motion.stage import MotionLikenessConfig, check_motion_likeness, motion_likeness
from sim1.scene.description import Camera, Scene, write_scene
from sim1.stage import BadInput

TINY = MotionLikenessConfig(path_count=1, moved_count=1, permutation_count=20, split_count=2)


def a_plan(reached, home, arms, model=None, seed=0, radius_m=0.02):
    variation = Variation(radius_m=radius_m, angle_rad=0.1, grasp_offset_m=0.0, settle_s=0.2)
    draw = drawn(reached, home.start_m.mean(axis=0), variation, np.random.default_rng(seed))
    rng = np.random.default_rng(seed + 1)
    lay = laid_as_placed(draw, arms)
    return draw, planned(reached, home, draw, lay, model or a_model(), arms, 0.2, lambda: rng)


@pytest.mark.parametrize("method", ["minimum_jerk", "slicing"])
def test_a_plan_goes_from_home_through_the_interaction_and_rests(reached, home, arms, method):
    draw, plan = a_plan(reached, home, arms, a_model(method))
    assert [span.kind for span in plan.spans] == ["moving", "interacting", "moving"]
    assert plan.joins == [span.start for span in plan.spans[1:]]
    assert plan.demos == [draw.picked[0].demo]
    middle = plan.spans[1]
    wanted = draw.picked[0].path.moved(draw.placement).position_m
    np.testing.assert_allclose(plan.path.position_m[middle.start : middle.end], wanted, atol=1e-6)
    assert speed_shares(plan.joints_rad, arms).max() <= 1
    if method == "minimum_jerk":
        np.testing.assert_allclose(plan.joints_rad[-1], HOME, atol=1e-3)


def test_a_hurried_plan_is_given_the_time_that_the_joints_need(reached, home, arms, monkeypatch):
    ways = []  # all that were tried
    monkeypatch.setattr(joining, "transition", lambda *given: ways.append(transition(*given)) or ways[-1])
    _, plan = a_plan(reached, home, arms, a_model(rest_s=0.05))
    assert speed_shares(arms.joints_for(ways[0][1:-1], HOME, FREE), arms).max() > 1.2
    assert len(ways[1]) > len(ways[0])
    fastest = speed_shares(plan.joints_rad, arms).max()
    assert 0.5 < fastest <= 1
    assert plan.speed_share == pytest.approx(fastest)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_slice_home_goes_on_with_the_demonstration_of_the_last_interaction(reached, home, arms, seed):
    draw, plan = a_plan(reached, home, arms, a_model("slicing"), seed)
    assert draw.picked[0].demo != "0000"
    ways = {part.demo: part.path.position_m for part in reached if part.kind == "moving" and part.order == 1}
    until = len(plan.path) - 6  # 0.2 s of rest at the end
    errors = {
        demo: np.abs(plan.path.position_m[until + 1 - len(way) : until] - way[1:]).max() for demo, way in ways.items()
    }
    assert errors[draw.picked[0].demo] < 1e-6
    assert sorted(errors.values())[1] > 1e-4


def test_the_joints_of_a_plan_carry_the_tools_along_its_path(reached, home, arms):
    _, plan = a_plan(reached, home, arms)
    tools = arms.tool_path(plan.joints_rad, plan.path.openness)
    np.testing.assert_allclose(tools.position_m, plan.path.position_m, atol=1e-3)


def test_a_plan_starts_with_the_first_command_of_a_demonstration(reached, home, arms):
    _, plan = a_plan(reached, replace(home, first_openness=np.full(2, 0.4)), arms)
    assert plan.path.openness[0] == pytest.approx(0.4, abs=0.01)
    assert plan.path.openness[-1] == pytest.approx(1.0)


def test_a_draw_out_of_reach_is_no_plan_and_says_why(reached, home, arms):
    far = [
        part.__class__(**{**part.__dict__, "path": part.path.moved(np.eye(4) + 2 * np.eye(4, k=3))}) for part in reached
    ]
    _, made = a_plan(far, home, arms)
    assert isinstance(made, NoPlan)
    assert made.failure == "unreachable"


def test_plans_read_like_demonstrations_with_the_sources_of_their_transitions(reached, home, arms):
    plans = [a_plan(reached, home, arms, seed=seed)[1] for seed in (0, 1)]
    paths = planned_paths(plans)
    assert [item.order for item in paths.movements] == [0, 1, 0, 1]
    assert [item.sources for item in paths.movements] == [frozenset(plan.demos) for plan in plans for _ in range(2)]
    mixed = planned_paths([replace(plans[0], demos=["0003", "0007"])])
    assert [item.sources for item in mixed.movements] == [frozenset({"0003", "0007"})] * 2
    assert [len(path) for path in paths.tools] == [len(plan.path) for plan in plans]
    own = paths_of(reached)
    assert len(own.movements) == 20
    assert own.joins[0] == [40, 85]


@pytest.fixture(scope="module")
def artifacts(tmp_path_factory, reached, home):
    root = tmp_path_factory.mktemp("artifacts")
    folders = {name: {"sheet": root / name} for name in ("segment_pool", "motion_model", "seed_demos", "scene")}
    for item in folders.values():
        item["sheet"].mkdir()
    write_pool(root / "segment_pool", reached)
    write_model(root / "motion_model", a_model())
    frames = 4
    np.savez(root / "seed_demos" / "start.npz", garment_m=home.start_m)
    still = Episode(
        time_s=np.arange(frames) / 30, joints_rad=np.tile(HOME, (frames, 1, 1)), openness=np.ones((frames, 2)),
        command_joints_rad=np.tile(HOME, (frames, 1, 1)), command_openness=np.ones((frames, 2)),
        garment_m=np.tile(home.start_m, (frames, 1, 1)), about={"success": True},
    )  # fmt: skip
    write_episode(root / "seed_demos" / "episodes" / "0000", still)
    (root / "scene" / "robot.urdf").write_bytes(URDF.read_bytes())
    (root / "scene" / "table.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    camera = Camera(width=64, height=48, fy_px=40.0, pose=np.eye(4))
    scene = Scene(
        table_mesh=root / "scene" / "table.obj", table_size_m=np.array([0.8, 1.2, 0.03]), table_top_m=0.0,
        urdf=root / "scene" / "robot.urdf", base_to_world=dict(zip(ARMS, BASES, strict=True)),
        home_rad=dict(zip(ARMS, HOME, strict=True)), garment_place=np.eye(4), cameras={"head": camera},
        wrist_cameras={name: replace(camera, link="link6") for name in ARMS},
    )  # fmt: skip
    write_scene(root / "scene", scene)
    return folders


@pytest.fixture(scope="module")
def measured(artifacts, tmp_path_factory):
    out = tmp_path_factory.mktemp("likeness")
    return out, motion_likeness(artifacts, out, TINY)


def test_the_stage_measures_what_it_can_and_names_what_it_cannot(measured):
    out, facts = measured
    record = json.loads((out / "likeness.json").read_text())
    assert record["schema"] == "sim1.likeness/1"
    assert set(record["figures"]) == {"demonstrations", "minimum_jerk", "slicing"}
    assert record["counts"]["plans"]["minimum_jerk"]["planned"] == 1
    assert record["figures"]["minimum_jerk"]["auc"] == {"not_measured": "2 transitions, 16 needed"}
    halves = "10 transitions in half of the demonstrations, 16 needed"  # ten demonstrations
    assert record["figures"]["demonstrations"]["auc"] == {"not_measured": halves}
    assert facts["plan_count"] == 1
    assert facts["auc"].startswith("not measured: 2 transitions, 16 needed")


def test_slices_are_found_to_be_copies(measured):
    out, _ = measured
    record = json.loads((out / "likeness.json").read_text())
    assert record["figures"]["slicing"]["copies"]["value"] > 0
    assert record["figures"]["minimum_jerk"]["copies"]["value"] == 0


def test_the_page_stands_alone_and_names_the_stand_in(measured):
    out, _ = measured
    page = (out / "report.html").read_text()
    assert "scripted expert" in page
    assert "not measured: 2 transitions, 16 needed" in page
    assert 'src="data:image/png;base64,' in page
    assert "http" not in page


def test_the_check_passes_with_warnings_for_limits_alone(measured):
    out, _ = measured
    findings = check_motion_likeness(out)
    assert all(finding.passed for finding in findings if finding.blocking)
    assert {finding.name for finding in findings if not finding.blocking} == {
        "limit_join", "limit_jerk_share", "limit_path_share", "limit_auc", "limit_copies"
    }  # fmt: skip


@pytest.mark.parametrize(
    "damage", [lambda text: text[:100], lambda text: text.replace('"value": ', '"value": NaN, "was": ', 1)]
)
def test_damaged_figures_are_blocking(measured, tmp_path, damage):
    out, _ = measured
    for path in out.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / "likeness.json").write_text(damage((out / "likeness.json").read_text()))
    assert any(finding.blocking and not finding.passed for finding in check_motion_likeness(tmp_path))


def test_the_same_inputs_give_the_same_bytes(measured, artifacts, tmp_path):
    out, _ = measured
    motion_likeness(artifacts, tmp_path, TINY)
    for path in sorted(out.iterdir()):
        assert path.read_bytes() == (tmp_path / path.name).read_bytes(), path.name


def test_a_pool_that_nobody_can_reach_is_refused_with_the_reason(artifacts, reached, tmp_path):
    far = [
        part.__class__(**{**part.__dict__, "path": part.path.moved(np.eye(4) + 2 * np.eye(4, k=3))}) for part in reached
    ]
    write_pool(tmp_path, far)
    with pytest.raises(BadInput, match=r"no path could be planned \(unreachable\)"):
        motion_likeness({**artifacts, "segment_pool": {"sheet": tmp_path}}, tmp_path, replace(TINY, tries_per_path=1))


def test_straight_lines_are_measured_beside_the_baselines(artifacts, tmp_path):
    (tmp_path / "model").mkdir()
    (tmp_path / "out").mkdir()
    write_model(tmp_path / "model", a_model("straight"))
    motion_likeness({**artifacts, "motion_model": {"sheet": tmp_path / "model"}}, tmp_path / "out", TINY)
    record = json.loads((tmp_path / "out" / "likeness.json").read_text())
    assert set(record["figures"]) == {"demonstrations", "straight", "minimum_jerk", "slicing"}
    assert record["figures"]["straight"]["path_ratio"]["value"] == pytest.approx(1, abs=0.05)
    assert "Straight lines" in (tmp_path / "out" / "report.html").read_text()
