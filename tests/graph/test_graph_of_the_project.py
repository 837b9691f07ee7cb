"""The project's own graph, ablations included, with toy work in every stage: what one moved vertex re-derives."""

import shutil
from pathlib import Path

import pytest
import yaml
from test_graph_regeneration import changed_since
from toy_home import Project, enter, furnish

from assets_defs._recipe import Snapshot, label
from pipeline.graph import load_graph
from pipeline.home import REPOSITORY, Home

pytestmark = pytest.mark.timeout(
    900
)  # every artifact of the project is made, most of them twice; 100 s on two idle cores

# Toy work reads the text files of a folder and every other source that is a file.
FILES = ("robot/arm.urdf", "environment/table.yaml", "appearance/fabrics.txt", "policies/act.yaml", "prices.yaml")


@pytest.fixture(scope="module")
def whole_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A home with the project's own graph where everything was made, to be copied."""
    root = tmp_path_factory.mktemp("whole") / "home"
    furnish(root)
    source = yaml.safe_load((REPOSITORY / "pipeline" / "stages.yaml").read_text())
    for row in source["stages"]:
        row["run"] = "toy_stages:ingest" if row["name"] == "scan" else "toy_stages:work"
    (root / "pipeline" / "stages.yaml").write_text(yaml.safe_dump(source))
    shutil.copy(REPOSITORY / "pipeline" / "ablations.yaml", root / "pipeline")
    for name in ("study", "paper"):  # ablations name them
        (root / "pipeline" / "profiles" / f"{name}.yaml").write_text("{}\n")
    for name in ("tasks/towel.yaml", "tasks/shirt.yaml", *FILES):
        (root / "data" / name).parent.mkdir(exist_ok=True)
        (root / "data" / name).write_text(f"{name}\n")
    with pytest.MonkeyPatch.context() as monkeypatch:
        assert not enter(root, monkeypatch).run().failed
    return root


@pytest.fixture
def whole(whole_once: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Project:
    """A home with the project's own graph where everything was made."""
    shutil.copytree(whole_once, tmp_path / "home")
    return enter(tmp_path / "home", monkeypatch)


def artifacts_of(graph, ids: set[str], garments: tuple[str, ...]) -> set[str]:
    return {name for id_ in ids for name in ([f"{id_}/{key}" for key in garments] if graph.nodes[id_].per else [id_])}


def not_fresh(project: Project) -> set[str]:
    """Labels of the artifacts that a run of everything would make."""
    with project.instance() as instance:
        snapshot = Snapshot(instance, project.graph, project.home)
        return {label(node, key) for node, key in snapshot.artifacts() if snapshot.status(node, key).state != "fresh"}


def test_one_moved_vertex_of_the_towel_makes_its_chain_and_the_joint_artifacts_stale_alone(whole):
    assert not_fresh(whole) == set()
    whole.add_garment("towel", "point 0 0 0.001")
    stale = not_fresh(whole)
    assert stale == artifacts_of(whole.graph, whole.graph.descendants({"scan"}), ("towel",))
    assert not {"recordings/towel", "calibrated_physics/towel", "mismatch_report/towel"} & stale
    assert [name for name in stale if name.endswith("/shirt")] == []


@pytest.mark.slow
def test_one_moved_vertex_of_the_towel_re_derives_its_chain_and_the_joint_artifacts_alone(whole):
    project, data = whole, whole.root / "data"
    before = project.events()
    project.add_garment("towel", "point 0 0 0.001")
    stale = not_fresh(project)
    assert not project.run().failed
    made = changed_since(project, before)
    assert set(made) == stale
    assert len(made) == len(stale)

    (data / "tasks" / "shirt.yaml").write_text("another fold\n")
    before = project.events()
    project.run(nodes={"scan", "garment_mesh", "scene", "seed_demos", "segment_pool"})
    assert changed_since(project, before) == ["seed_demos/shirt", "segment_pool/shirt"]


def test_further_demonstrations_of_the_towel_leave_every_other_garments_episodes_as_they_are(whole):
    given = whole.root / "data" / "demonstrations" / "towel"
    given.mkdir(parents=True)
    (given / "commands.txt").write_text("left, right\n")
    stale = not_fresh(whole)
    demonstrated = {id_ for id_, node in whole.graph.nodes.items() if node.stage.name == "seed_demos"}
    assert stale == artifacts_of(whole.graph, whole.graph.descendants(demonstrated), ("towel",))
    assert {"seed_demos/towel", "rendered_episodes/towel", "dataset"} <= stale
    assert [name for name in stale if name.endswith("/shirt")] == []


def test_a_changed_fabric_makes_the_frames_stale_and_what_is_made_from_them_and_nothing_above(whole):
    (whole.root / "data" / "appearance" / "fabrics.txt").write_text("another red\n")
    with whole.instance() as instance:
        snapshot = Snapshot(instance, whole.graph, whole.home)
        found = {label(node, key): snapshot.status(node, key) for node, key in snapshot.artifacts()}
    rendered = {id_ for id_, node in whole.graph.nodes.items() if node.stage.name == "rendered_episodes"}
    stale = {name for name, status in found.items() if status.state == "stale"}
    assert stale == artifacts_of(whole.graph, rendered, ("shirt", "towel"))
    assert {found[name].why for name in stale} == {"source appearance changed"}
    below = whole.graph.descendants(rendered)
    assert {name for name, status in found.items() if status.state != "fresh"} == artifacts_of(
        whole.graph, below, ("shirt", "towel")
    )
    assert {whole.graph.nodes[id_].stage.name for id_ in below - rendered} == {
        "dataset",
        "policy",
        "image_policy",
        "image_trials",
        "scaling_report",
        "ablation_report",
        "cost_report",
    }


def test_an_ablation_of_the_pictures_ends_in_trials_of_its_own_and_makes_nothing_beside_them():
    graph = load_graph(Home(REPOSITORY), "study")
    own = {node.stage.name for node in graph.nodes.values() if node.variant == "one_look"}
    assert own == {"rendered_episodes", "dataset", "image_policy", "image_trials"}
    assert not any(graph.nodes[need].variant for need in graph.nodes["policy"].needs.values())
    assert not any("one_look" in need for need in graph.nodes["ablation_report"].needs)
    assert not any(node.variant == "one_look" for node in load_graph(Home(REPOSITORY), "quick").nodes.values())
