"""What the simulator leaves of films at their true parameters, by mesh, pull and step."""

import json
import shutil

import pytest
from small_bundle import empty_bundle, filmed

from benchmarks.diagnosis.at_truth import CHANGES, KINDS, at_truth
from sim1.cloth.effects import EFFECTS
from sim1.mismatch.search import baseline
from sim1.recording.bundle import write_bundle

DRAG = {"c_normal": 2.0, "c_tangential": 0.02}


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """Filmed by the simulator itself, on the mesh refined twice, free, with steps of 1/240 s and hardly any noise."""
    given = empty_bundle(motions=1, duration_s=1.2)
    nominal = baseline(given).nominal[:4]
    true = {one.name: one.value(z) for one, z in zip(nominal, (0.5, -0.4, 0.6, -0.5), strict=True)}
    folder = tmp_path_factory.mktemp("laboratory") / "drag"
    world = EFFECTS["air_drag"](**DRAG).act(baseline(given).base)
    air = {"air_normal": world.air_normal, "air_skin": world.air_skin}
    write_bundle(folder / "bundle", filmed(given, noise_m=2e-5, **air))
    answers = {
        "case": {"effects": ["air_drag"], "strength": "medium", "seed": 1},
        "effects": [{"name": "air_drag", "parameters": DRAG, "named_by_format": True}],
        "baseline": true,
        "places_given": True,
    }
    (folder / "answers.json").write_text(json.dumps(answers))
    return folder


def rows(table):
    """Millimetres by the names of columns, of each recording."""
    told, names, _, *lines = [line for line in table.splitlines() if line]
    columns = [name.strip() for name in names.strip("|").split("|")][1:]
    assert columns == [*KINDS, *CHANGES]
    return told, {
        name.strip(): dict(zip(columns, map(float, cells), strict=True))
        for name, *cells in (line.strip("|").split("|") for line in lines)
    }


def test_the_finer_the_mesh_the_less_is_left_at_the_truth(case):
    told, found = rows(at_truth(case))
    assert "steps of 1/240 s" in told
    one = found["swing_0"]
    assert one["refined twice"] < one["refined"] < one["as given"]
    assert one["refined, free"] < one["as given, free"]
    assert one["once more"] < one["refining changes"]


def test_more_is_left_where_answers_are_wrong(case, tmp_path):
    told = json.loads((case / "answers.json").read_text()) | {"effects": []}
    shutil.copytree(case / "bundle", tmp_path / "bundle")
    (tmp_path / "answers.json").write_text(json.dumps(told))
    assert left(tmp_path) > 2 * left(case)


def test_a_longer_step_leaves_more(case):
    told, found = rows(at_truth(case, step_s=1 / 60))
    assert "steps of 1/60 s" in told
    assert found["swing_0"]["refined twice"] > 2 * left(case)


def left(folder):
    """Millimetres, on the mesh of the film."""
    return rows(at_truth(folder))[1]["swing_0"]["refined twice"]
