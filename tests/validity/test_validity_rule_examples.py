"""What state rules are learned from, and what is refused as rules."""

import json

import pytest
from validity_synthetic import TINY, make_artifacts

from sim1.cloth.garment import read_garment_mesh
from sim1.scene.description import read_scene
from sim1.stage import BadInput
from sim1.validity.rules import read_rules
from sim1.validity.watching import labelled_clips


def test_a_fold_out_of_view_is_a_failure_to_video_which_sees_where_it_lay(tmp_path):
    inputs = make_artifacts(tmp_path, [1.0, 0.99], [1.0, 0.99, 0.5])
    folder = inputs["candidate_trajectories"]["sheet"] / "episodes/0001"
    about = json.loads((folder / "episode.json").read_text()) | {"success": False, "failure": "out of view"}
    (folder / "episode.json").write_text(json.dumps(about))
    paths = {name: artifacts["sheet"] for name, artifacts in inputs.items()}
    mesh, scene = read_garment_mesh(paths["garment_mesh"]), read_scene(paths["scene"])
    clips = labelled_clips(paths["seed_demos"], paths["candidate_trajectories"], mesh, scene, TINY)
    assert {clip.name: clip.success for clip in clips}["candidate/0001"] is False


@pytest.mark.parametrize(
    ("entry", "complaint"),
    [
        ("{feature: end.speed_m_s, below: '0.5'}", r"below of end\.speed_m_s is '0\.5', expected a number"),
        ("{feature: end.speed_m_s, above: true}", r"above of end\.speed_m_s is True, expected a number"),
        ("{feature: end.speed_m_s, above: .nan}", r"above of end\.speed_m_s is nan, expected a number"),
        ("{feature: 7, above: 1.0}", "feature is 7, expected its name"),
        ("{above: 1.0}", "feature"),
    ],
)
def test_rules_whose_values_are_of_another_type_are_refused_as_they_are_read(tmp_path, entry, complaint):
    path = tmp_path / "rules.yaml"
    path.write_text(f"schema: sim1.rules/1\nmethod: tree\nreason: a test\nany_of: [{{all_of: [{entry}]}}]\n")
    with pytest.raises(BadInput, match=rf"rules\.yaml: not readable rules \(.*{complaint}.*make state_rules again"):
        read_rules(path)
