"""Damage that no cheap look sees, and what an interrupted run left: the remedy helps, and nothing strange gets in."""

import os

from assets_defs._digest import digest_json
from assets_defs._recipe import Snapshot
from assets_defs._store import place


def test_the_remedy_for_damage_that_keeps_size_and_time_helps_and_nothing_is_held_against_who_noticed(made):
    nodes = made.graph.nodes
    file = place(made.home, nodes["mesh"], "towel").final / "content.txt"
    stat = file.stat()
    file.write_bytes(b"y" + file.read_bytes()[1:])
    os.utime(file, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    assert made.run().made == {}  # nobody reads every byte of what nobody needs
    made.stages(model={"version": 2})
    report = made.run(nodes={"model"}, garments=["towel"])
    assert "damaged: content.txt has other content" in report.failed["model/towel"]
    assert "sim1 run --select mesh --garment towel" in report.failed["model/towel"]
    assert place(made.home, nodes["model"], "towel").failed() is None
    assert "mesh/towel: damaged: content.txt" in made.command("status").stdout
    answer = made.command("run", "--select", "mesh", "--garment", "towel", "--jobs", "0")
    assert "1 made" in answer.stdout
    assert {"model/towel", "model/shirt"} <= set(made.run().made)
    assert made.run().made == {}


def test_what_an_interrupted_run_left_does_not_get_into_a_copy_of_the_same_work(project):
    # Comments do not count in what `ingest` writes, so both variants of `mesh` give the same artifact.
    project.stages(mesh={"run": "toy_stages:ingest"}, model={"resumes": True})
    (project.root / "pipeline" / "ablations.yaml").write_text("variants: {other: {changes: {mesh: {unused: 1}}}}\n")
    project.run(nodes={"scan", "mesh", "other/mesh", "model"})
    node = project.graph.nodes["other/model"]
    at = place(project.home, node, "towel")
    with project.instance() as instance:
        parts = Snapshot(instance, project.graph, project.home).parts(node, "towel")
    (at.begin(digest_json(parts), resume=False) / "half.txt").write_text("half")
    assert not project.run().failed
    assert at.record()["facts"]["same_work_as"] == "model/towel"
    assert at.record()["files"].keys() == {"content.txt"}
