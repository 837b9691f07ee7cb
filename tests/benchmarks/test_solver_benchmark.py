import json

import numpy as np
import pytest

from benchmarks.solver import cost, equal, gpu, growth, picture, scenes
from benchmarks.solver.contestants import Contestant, corner_way_m
from benchmarks.solver.stretch import pull, rounded


def test_sheet_has_the_asked_mass_size_and_edges():
    sheet = scenes.square(6)
    assert sheet.area_m2 == pytest.approx(0.36)
    assert len(sheet.faces) == 50
    assert len(sheet.edges) == 2 * 6 * 5 + 25


def test_folding_keeps_edges_and_brings_layers_to_the_asked_distance():
    sheet = scenes.folded(16, gap_m=0.005)
    ends = sheet.start_m[sheet.edges]
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    assert (length <= sheet.edge_length_m * (1 + 1e-9)).all()
    assert np.median(cost.facing_gaps_m(sheet.start_m, 16)) == pytest.approx(0.005)


def test_corner_gets_to_its_speed_without_a_jump():
    assert corner_way_m(0.0) == 0.0
    assert corner_way_m(0.1) == pytest.approx(0.025)
    assert corner_way_m(0.5) - corner_way_m(0.3) == pytest.approx(0.1)


@pytest.mark.parametrize("kind", ["SolverAVBD", "SolverVBD", "MuJoCo elastic", "MuJoCo edges 0.99"])
def test_pull_measures_a_stretch_that_can_be(kind):
    found = pull(Contestant(kind=kind, iterations=3), scenes.square(6), simulated_s=0.02)
    assert found.simulated_s == pytest.approx(0.02)
    assert 1.0 <= found.p99 <= found.largest < 1.5
    assert json.loads(json.dumps(found.document()))["vertices"] == 36


def test_pull_stops_where_the_limit_is_passed():
    soft = Contestant(kind="SolverVBD", iterations=1, modulus_n_m=1.0)
    found = pull(soft, scenes.square(6), simulated_s=0.2, stop_above=1.06)
    assert found.simulated_s < 0.2
    assert found.largest > 1.06


def test_cost_growth_and_worlds_name_both_solvers():
    rows = [cost.without_contact(5, 2, rounds=1)]
    rows += growth.with_vertices((5,), (5,), simulated_s=0.01, rounds=1)
    assert all(row["seconds_per_step_SolverAVBD"] > 0 and row["seconds_per_step_SolverVBD"] > 0 for row in rows)
    (row,) = growth.with_worlds((2,), 5, rounds=1)
    assert row["worlds"] == 2


def test_throughput_counts_worlds_on_any_device():
    (row,) = gpu.throughput("cpu", worlds=(2,), side=5)
    assert row["steps_per_second_SolverAVBD"] > 0
    assert row["steps_per_second_SolverVBD"] > 0


def test_settings_keep_the_asked_number_of_iterations_per_second():
    for setting in equal.settings(4000.0):
        assert setting.iterations * setting.steps_per_s == pytest.approx(4000, rel=0.02)


def test_figures_that_are_no_numbers_stay_out_of_the_file():
    assert rounded(float("nan")) is None
    assert rounded(1.23456) == 1.235


def test_picture_is_drawn_from_the_document(tmp_path):
    cloth = scenes.square(5)
    pulled = pull(Contestant(kind="MuJoCo edges 0.99"), cloth, simulated_s=0.01)
    row = {
        "solver": "SolverAVBD",
        "iterations": 5,
        **{k: v for k, v in pulled.document().items() if k not in ("solver", "iterations")},
    }
    ratio = {"vertices": 25, "ratio": 0.2, "seconds_per_step_SolverAVBD": 1e-3, "seconds_per_step_SolverVBD": 5e-3}
    document = {
        "pull": [row, pulled.document()],
        "cost": {"without_self_contact": ratio, "with_self_contact": {"lying": ratio}},
        "equal_stretch": [{"limit": 1.06, "SolverAVBD": row, "SolverVBD": None}],
        "growth": {"vertices": [ratio]},
    }
    picture.draw(document, [(pulled, cloth)], tmp_path / "solver.png")
    assert (tmp_path / "solver.png").stat().st_size > 10_000
