"""`sim1 recordings check` measures what is known of a board on a bar, and says what its motions can tell."""

import json
from dataclasses import replace

import numpy as np
import pytest
from swinging import BAR_M, board_bundle, board_markers, swing, without_places
from typer.testing import CliRunner

from assets_defs._recordings import recordings as command
from sim1.cloth.effects import EFFECTS
from sim1.recording.bundle import read_bundle, write_bundle
from sim1.recording.examination import cannot_tell, examine
from sim1.recording.figures import measure
from sim1.recording.rule_table import RULES
from sim1.recording.rules import Rule, statements


def figures_of(recording, **options):
    return measure(board_bundle(recording, **options), recording)


def said_of(*recordings, folder, **options):
    write_bundle(folder, board_bundle(*recordings, **options))
    examination = examine(folder)
    assert not examination.problems
    return {said.text: said.can for said in examination.statements}


def only(said, words):
    found = {text: can for text, can in said.items() if words in text}
    assert len(found) == 1, said
    return next(iter(found.items()))


def test_what_a_diagnosis_lists_as_untold_is_what_the_check_says_cannot_be_told(tmp_path):
    write_bundle(tmp_path / "b", board_bundle(swing("a"), swing("b")))
    untold = cannot_tell(read_bundle(tmp_path / "b"))
    assert untold
    assert [said.text for said in untold] == [said.text for said in examine(tmp_path / "b").statements if not said.can]
    assert all(said.record for said in untold)


def test_noise_is_measured_where_the_cloth_rests():
    noise = figures_of(swing("a", noise_m=7e-4)).noise
    assert noise.std_m == pytest.approx(7e-4, rel=0.05)
    assert noise.core_std_m == pytest.approx(7e-4, rel=0.08)
    assert noise.correlation_s == 0.0
    assert noise.at_rest


def test_gross_errors_widen_the_spread_and_not_its_core():
    recording = swing("a", noise_m=7e-4)
    recording.markers_m[10:60:7, 3] += 0.02
    noise = figures_of(recording).noise
    assert noise.core_std_m == pytest.approx(7e-4, rel=0.08)
    assert noise.std_m > 1.3 * noise.core_std_m


@pytest.mark.parametrize("correlation_s", [0.03, 0.06])
def test_the_time_that_noise_remembers_is_found(correlation_s):
    noise = figures_of(swing("a", noise_m=7e-4, correlation_s=correlation_s, rest_s=3.0)).noise
    assert noise.correlation_s == pytest.approx(correlation_s, rel=0.4)


def test_white_noise_on_a_slow_wander_shows_as_its_share():
    recording = swing("a", noise_m=5e-4, correlation_s=0.15, rest_s=4.0)
    recording.markers_m[:] += 5e-4 * np.random.default_rng(1).standard_normal(recording.markers_m.shape)
    noise = figures_of(recording).noise
    assert noise.slow_share == pytest.approx(0.5, abs=0.12)
    assert noise.correlation_s == pytest.approx(0.15, rel=0.4)


def test_without_rest_the_noise_is_bounded_from_the_motion():
    noise = figures_of(replace(swing("a", noise_m=7e-4), starts="moving")).noise
    assert not noise.at_rest
    assert noise.core_std_m == pytest.approx(7e-4, rel=0.15)


def test_speed_is_split_into_its_parts_across_and_along_the_cloth():
    recording = swing("a", peak_rad_s=3.0, shift_m=0.0)
    figures = figures_of(recording)
    turning = 3.0 * np.cos(2 * np.pi * np.clip(recording.time_s - 1.0, 0, None)) * (recording.time_s > 1.0)
    across = np.abs(turning[:, None] * board_markers()[:, 1])  # a pendulum moves across itself alone
    assert figures.normal_m_s[1] == pytest.approx(np.percentile(across, 95), rel=0.04)
    assert figures.tangential_m_s[1] < 0.02
    lifted = figures_of(swing("b", peak_rad_s=0.0, shift_m=0.0, drop_m=0.4))
    assert lifted.tangential_m_s[1] == pytest.approx(0.2, rel=0.05)
    assert lifted.normal_m_s[1] < 0.005


def test_rest_duration_and_rates_are_those_of_the_recording():
    figures = figures_of(swing("a", rest_s=0.7, moves_s=1.0))
    assert figures.rest_s == pytest.approx(0.7, abs=0.03)
    assert figures.duration_s == pytest.approx(3.19, abs=0.01)
    assert figures.marker_rate_hz == pytest.approx(100)
    assert figures.drive_rate_hz == pytest.approx(100)


def test_what_was_not_seen_is_counted():
    recording = swing("a")
    recording.markers_m[50:120, 5] = np.nan
    recording.markers_m[400:, 6] = np.nan
    figures = figures_of(recording)
    assert figures.longest_occlusion_s == pytest.approx(0.7, abs=0.011)
    assert figures.worst_marker == 5
    assert figures.worst_seen_share == pytest.approx(1 - 70 / len(recording.time_s))


def test_a_board_neither_bends_nor_stretches():
    figures = figures_of(swing("a"))
    assert max(figures.curvature_1_m) < 1e-6
    assert figures.strain < 1e-6
    assert not figures.folded


def test_a_board_that_is_pulled_longer_is_seen_to_be():
    recording = swing("a", peak_rad_s=0.0)
    middle = recording.markers_m.mean(1, keepdims=True)
    pull = 1 + 0.05 * np.clip(recording.time_s - 1, 0, 1)[:, None, None]
    pulled = replace(recording, markers_m=middle + (recording.markers_m - middle) * pull)
    assert figures_of(pulled).strain == pytest.approx(0.05, rel=0.02)


def test_noise_alone_is_not_taken_for_bending_or_stretch(tmp_path):
    said = said_of(swing("a", noise_m=1e-3), swing("b", noise_m=1e-3, seed=1), folder=tmp_path / "b")
    assert not only(said, "anisotropic_bending:")[1]
    assert not only(said, "strain_stiffening")[1]


def test_a_cloth_that_is_seen_flat_shows_its_shrinkage_unless_noise_hides_it(tmp_path):
    text, can = only(
        said_of(swing("a", noise_m=5e-4), swing("b", noise_m=5e-4), folder=tmp_path / "clear"), "shrinkage:"
    )
    assert can
    assert "flat in 2 recordings, where noise is 0.3" in text  # per cent of 0.225 m
    assert not only(
        said_of(swing("a", noise_m=2e-3), swing("b", noise_m=2e-3), folder=tmp_path / "noisy"), "shrinkage:"
    )[1]


def test_a_cloth_that_is_never_flat_does_not_show_its_shrinkage(tmp_path):
    bowls = [swing("a", noise_m=5e-4), swing("b", noise_m=5e-4, seed=1)]
    for recording in bowls:
        recording.markers_m[..., 1] += 8.0 * (recording.markers_m[0, :, 0] ** 2)
    text, can = only(said_of(*bowls, folder=tmp_path / "b"), "shrinkage:")
    assert not can
    assert "flat in 0 recordings" in text


def test_every_effect_has_a_rule():
    assert set(EFFECTS) <= {name for rule in RULES for name in rule.effects}


def test_contact_with_a_table_is_seen_and_sliding_and_lifting_too():
    flat = swing("a", peak_rad_s=0.0, shift_m=0.6)
    lying = replace(flat, markers_m=flat.markers_m * [1, 1, 0] + [0, 0, 0.001])
    figures = figures_of(lying, table_m=0.0)
    assert figures.touches_table_s == pytest.approx(4.5, abs=0.05)
    assert figures.slides_m_s[0] < 1e-6
    assert figures.slides_m_s[1] == pytest.approx(0.3, rel=0.05)
    assert not figures.lifts
    lying.markers_m[300:, 4, 2] = 0.1
    assert figures_of(lying, table_m=0.0).lifts
    assert figures_of(flat, table_m=0.0).touches_table_s == 0.0
    assert figures_of(flat).touches_table_s is None


def test_a_free_decay_is_time_after_a_sudden_stop_in_which_the_cloth_still_moves():
    assert figures_of(swing("a", shift_m=0.4)).free_decay_s == pytest.approx(1.5, abs=0.1)
    assert figures_of(swing("a", shift_m=0.4, peak_rad_s=0.0)).free_decay_s == 0.0
    assert figures_of(swing("a", shift_m=0.1)).free_decay_s == 0.0  # too slow a stop to tell a lag


def test_holds_that_are_let_go_or_not_measured_are_counted():
    recording = without_places(swing("a"))
    let_go = replace(recording, holds=(replace(recording.holds[0], to_s=2.0),))
    figures = figures_of(let_go)
    assert (figures.hold_count, figures.changed_holds, figures.measured_holds) == (1, 1, 0)
    assert figures_of(swing("a")).changed_holds == 0


def test_slow_swings_of_one_kind_cannot_tell_much(tmp_path):
    said = said_of(swing("a", peak_rad_s=0.5), swing("b", peak_rad_s=0.5, seed=1), folder=tmp_path / "b")
    for words in (
        "air_drag: the cloth moves",
        "air_drag vs added_mass",
        "added_mass vs area density",
        "added_mass vs gravity",
        "no recording touches",
        "always held",
        "wind:",
        "needs a free decay",
    ):
        assert not only(said, words)[1], words
    assert "speeds vary only from 0.1" in only(said, "air_drag vs added_mass")[0]


def test_fast_and_slow_swings_and_turns_can_tell_more(tmp_path):
    fast = swing("fast", peak_rad_s=6.0, shift_m=0.5, drop_m=0.5, turn_rad=1.0)
    lift = swing("lift", peak_rad_s=0.0, moves_s=0.7, drop_m=0.7)
    said = said_of(swing("slow", peak_rad_s=0.5), fast, lift, folder=tmp_path / "b")
    for words in (
        "air_drag: the cloth moves",
        "air_drag vs added_mass",
        "wind:",
        "clock_offset",
        "air_drag vs damping",
        "pace",
    ):
        assert only(said, words)[1], words
    for other in ("area density", "gravity"):
        assert only(said, f"added_mass vs {other}")[1], other


def test_unmeasured_places_are_named_unless_the_gripper_turns(tmp_path):
    still = [without_places(swing(name)) for name in "ab"]
    assert not only(said_of(*still, folder=tmp_path / "still"), "places_m is null in 2 of 2")[1]
    turned = [without_places(swing(name, turn_rad=0.8)) for name in "ab"]
    assert only(said_of(*turned, folder=tmp_path / "turned"), "unmeasured places")[1]


def test_a_density_without_a_scale_is_said_to_be_unknown(tmp_path):
    said = said_of(swing("a"), swing("b"), folder=tmp_path / "weighed")
    assert only(said, "area density: known")[1]
    bundle = board_bundle(swing("a"), swing("b"))
    guess = bundle.prior.area_density_kg_m2.model_copy(update={"std": None, "log_std": 0.5})
    bundle = replace(bundle, prior=bundle.prior.model_copy(update={"area_density_kg_m2": guess}))
    write_bundle(tmp_path / "guessed", bundle)
    assert not only({s.text: s.can for s in examine(tmp_path / "guessed").statements}, "not identifiable")[1]


def test_every_rule_can_be_said_both_ways():
    names = {rule.figure for rule in RULES} | {rule.asked for rule in RULES if rule.asked}
    for value in (0.0, 1e3, None):
        figures = dict.fromkeys(overall_names(), value) | dict.fromkeys({"holds", "touches_s", "unmeasured_holds"}, 1.0)
        assert names <= set(figures)
        for said in statements(figures, RULES):
            assert said.can == (not said.record)
            assert "{" not in said.text


def overall_names():
    from sim1.recording.overall import overall

    recording = swing("a")
    bundle = board_bundle(recording)
    return overall(bundle, [measure(bundle, recording)])


def test_a_rule_is_added_by_a_row():
    row = Rule(effects=("magnets",), figure="rest_s", least=2.0, can="yes", cannot="only {rest_s} s", record="wait")
    [said] = statements({"rest_s": 1.0}, [row])
    assert (said.can, said.text, said.record) == (False, "only 1.0 s", "wait")


def run(*words):
    return CliRunner().invoke(command, ["check", *map(str, words)])


def test_the_command_ends_with_0_for_a_usable_bundle_and_says_what_is_in_it(tmp_path):
    write_bundle(tmp_path / "b", board_bundle(swing("left"), swing("right")))
    result = run(tmp_path / "b")
    assert result.exit_code == 0
    for word in ("left", "right", "noise", "cannot", "no recording touches the table", "usable"):
        assert word in result.output, word


def test_the_command_ends_with_1_for_one_recording_alone(tmp_path):
    write_bundle(tmp_path / "b", board_bundle(swing("alone")))
    result = run(tmp_path / "b")
    assert result.exit_code == 1
    assert "needs 2 or more" in result.output
    assert "nothing can be held out" in result.output


def test_the_command_ends_with_1_for_a_damaged_bundle_and_names_all_that_is_wrong(tmp_path):
    write_bundle(tmp_path / "b", board_bundle(swing("a"), swing("b")))
    (tmp_path / "b/recordings/a/drives.parquet").unlink()
    (tmp_path / "b/recordings/b/markers.parquet").write_bytes(b"no")
    result = run(tmp_path / "b", "--json")
    answer = json.loads(result.output)
    assert result.exit_code == 1
    assert answer["reads"] is False
    assert len(answer["problems"]) == 2
    assert "a/drives.parquet" in answer["problems"][0]
    assert run(tmp_path / "nowhere").exit_code == 1


def test_the_json_holds_the_figures_and_the_statements(tmp_path):
    write_bundle(tmp_path / "b", board_bundle(swing("a", noise_m=1e-3), swing("b"), table_m=BAR_M - 1))
    answer = json.loads(run(tmp_path / "b", "--json").output)
    assert answer["schema"] == "sim1.recordings-check/1"
    assert answer["usable"] is True
    assert answer["recordings"][0]["noise"]["std_m"] == pytest.approx(1e-3, rel=0.05)
    assert {"effects", "can", "text", "record"} == set(answer["statements"][0])
