"""The project's own graph, ablations included, with toy work in every stage: what one moved vertex re-derives."""

import shutil

import yaml
from test_graph_regeneration import changed_since

from pipeline.home import REPOSITORY


def test_one_moved_vertex_of_the_towel_re_derives_its_chain_and_the_joint_artifacts_alone(project):
    source = yaml.safe_load((REPOSITORY / "pipeline" / "stages.yaml").read_text())
    for row in source["stages"]:
        row["run"] = "toy_stages:ingest" if row["name"] == "scan" else "toy_stages:work"
    (project.root / "pipeline" / "stages.yaml").write_text(yaml.safe_dump(source))
    shutil.copy(REPOSITORY / "pipeline" / "ablations.yaml", project.root / "pipeline")
    for name in ("study", "paper"):  # ablations name them
        (project.root / "pipeline" / "profiles" / f"{name}.yaml").write_text("{}\n")
    data = project.root / "data"
    for name in (
        "tasks/towel.yaml",
        "tasks/shirt.yaml",
        "robot/arm.urdf",
        "environment/table.yaml",
        "policies/act.yaml",
        "prices.yaml",
    ):
        (data / name).parent.mkdir(exist_ok=True)
        (data / name).write_text(f"{name}\n")
    assert not project.run().failed
    before = project.events()

    project.add_garment("towel", "point 0 0 0.001")
    assert not project.run().failed
    made = changed_since(project, before)

    graph = project.graph
    below = graph.descendants({"scan"})
    expected = {f"{id_}/towel" if graph.nodes[id_].per else id_ for id_ in below}
    assert set(made) == expected
    assert len(made) == len(expected)
    assert not {"recordings/towel", "calibrated_physics/towel", "mismatch_report/towel"} & set(made)
    assert [name for name in made if name.endswith("/shirt")] == []

    (data / "tasks" / "shirt.yaml").write_text("another fold\n")
    before = project.events()
    project.run(nodes={"scan", "garment_mesh", "scene", "seed_demos", "segment_pool"})
    assert changed_since(project, before) == ["seed_demos/shirt", "segment_pool/shirt"]
