"""`sim1 audit` speaks of the artifact that was asked for, and of the runs that made it."""

import json

import pytest

from assets_defs._store import place


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ("mesh", "mesh: every garment has its own; sim1 audit mesh/GARMENT, of ['shirt', 'towel']"),
        ("dataset/towel", "dataset/towel: dataset exists once for all garments; sim1 audit dataset"),
        ("wide/model", "sim1 audit wide/model/GARMENT, of ['shirt', 'towel']"),
    ],
)
def test_a_garment_that_is_missing_or_too_much_is_said(made, asked, said):
    (made.root / "pipeline" / "ablations.yaml").write_text("variants: {wide: {changes: {model: {width: 9}}}}\n")
    for options in ([], ["--json"]):
        answer = made.command("audit", asked, *options)
        assert answer.returncode == 2
        assert answer.stdout == ""
        assert said in answer.stderr


def test_an_ancestor_is_the_run_that_came_before_its_child_though_a_later_one_made_the_same(made):
    before = json.loads(made.command("audit", "dataset", "--json").stdout)["ancestry"]
    # What the toy stage writes does not depend on the version: same content, another run.
    made.stages(mesh={"version": 2})
    assert sorted(made.run().made) == ["mesh/shirt", "mesh/towel"]
    newest = json.loads(made.command("audit", "mesh/towel", "--json").stdout)["ancestry"]["mesh/towel"]
    assert newest["data_version"] == before["mesh/towel"]["data_version"]
    assert newest["version"] == 2
    after = json.loads(made.command("audit", "dataset", "--json").stdout)["ancestry"]
    assert after["mesh/towel"]["version"] == 1
    assert after == before
    assert place(made.home, made.graph.nodes["mesh"], "towel").record()["parts"]["version"] == 2
