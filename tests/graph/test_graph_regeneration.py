"""What is re-derived after a change, counted from the event log."""

import dagster as dg
import pytest

from assets_defs._factory import GARMENTS
from assets_defs._produce import produce
from assets_defs._recipe import RECIPE_TAG, Snapshot, asset_key
from assets_defs._regenerate import sync_garments
from assets_defs._store import place

TOWEL_CHAIN = ["scan/towel", "mesh/towel", "model/towel", "dataset", "report"]


def changed_since(project, before: list[str]) -> list[str]:
    events = project.events()
    assert events[: len(before)] == before
    return events[len(before) :]


def test_only_what_depends_on_a_change_is_made_again(made):
    before = made.events()

    assert made.run().made == {}
    assert changed_since(made, before) == []

    made.add_garment("towel", "point 0 0 1")
    made.run()
    assert changed_since(made, before) == TOWEL_CHAIN

    # A comment changes the file and not the artifact: the chain ends at the first unchanged output.
    before = made.events()
    made.add_garment("towel", "# measured on Monday\npoint 0 0 1")
    made.run()
    assert changed_since(made, before) == ["scan/towel"]

    before = made.events()
    made.stages(model={"config": {"width": 3}})
    made.run()
    assert changed_since(made, before) == ["model/shirt", "model/towel", "dataset", "report"]

    before = made.events()
    made.stages(model={"config": {"width": 3}}, mesh={"version": 2})
    made.run()
    # The digest that the toy stage writes does not depend on the version, so nothing below it changes.
    assert changed_since(made, before) == ["mesh/shirt", "mesh/towel"]

    before = made.events()
    made.add_garment("shorts")
    made.run()
    assert changed_since(made, before) == ["scan/shorts", "mesh/shorts", "model/shorts", "dataset", "report"]

    before = made.events()
    (made.root / "data" / "garments" / "shorts.yaml").unlink()
    made.run()
    assert changed_since(made, before) == ["dataset", "report"]


def test_an_input_that_changes_while_its_artifact_is_made_leaves_it_stale(made):
    made.stages(mesh={"config": {"sleep_s": 2}})
    changed = False

    class Meddler:
        def plan(self, seconds_left, count_left): ...
        def finished(self, name, seconds, message): ...
        def progress(self, name, done, total, what):
            nonlocal changed
            if name == "mesh/towel" and not changed:
                changed = True
                made.add_garment("towel", "point 9 9 9")

        def started(self, name): ...

    before = made.events()
    report = made.run(jobs=1, observer=Meddler())
    events = changed_since(made, before)
    assert not report.failed
    # Once for the setting, once more for the edit; the shirt once.
    assert events.count("mesh/towel") == 2
    assert events.count("mesh/shirt") == 1
    with made.instance() as instance:
        snapshot = Snapshot(instance, made.graph, made.home)
        assert {snapshot.status(node, key).state for node, key in snapshot.artifacts()} == {"fresh"}


@pytest.mark.slow
def test_one_of_150_parents_of_a_fan_in_is_noticed(project):
    for number in range(148):
        project.add_garment(f"g{number:03}")
    with project.instance() as instance:
        sync_garments(project.home, instance)
        assert len(instance.get_dynamic_partitions(GARMENTS.name)) == 150

        def make(node_ids, garments=None):
            for node_id in node_ids:
                snapshot = Snapshot(instance, project.graph, project.home)
                node = project.graph.nodes[node_id]
                for key in snapshot.keys(node):
                    if garments is None or key in garments:
                        record = produce(project.home, snapshot, node, key, lambda *_: None).record
                        tags = {RECIPE_TAG: record["recipe"], "dagster/data_version": record["data_version"]}
                        event = dg.AssetMaterialization(asset_key(node), partition=key, tags=tags)
                        instance.report_runless_asset_event(event)

        make(["scan", "mesh", "model", "dataset"])
        dataset = project.graph.nodes["dataset"]
        assert Snapshot(instance, project.graph, project.home).status(dataset, None).state == "fresh"
        project.add_garment("g077", "point 7 7 7")
        make(["scan", "mesh", "model"], ["g077"])
        status = Snapshot(instance, project.graph, project.home).status(dataset, None)
        assert status.state == "stale"
        assert "g077" in status.why


def test_variants_re_derive_their_own_assets_alone(project):
    (project.root / "pipeline" / "ablations.yaml").write_text("variants: {wide: {changes: {model: {width: 9}}}}\n")
    report = project.run()
    own = sorted(name for name in report.made if name.startswith("wide/"))
    assert own == ["wide/dataset", "wide/model/shirt", "wide/model/towel"]
    before = project.events()
    (project.root / "pipeline" / "ablations.yaml").write_text("variants: {wide: {changes: {model: {width: 10}}}}\n")
    project.run()
    assert changed_since(project, before) == ["wide/model/shirt", "wide/model/towel", "wide/dataset", "report"]


def test_a_variant_that_turns_out_to_change_nothing_costs_nothing_below(project):
    # Comments do not count in what `ingest` writes, so both variants of `mesh` give the same artifact.
    project.stages(mesh={"run": "toy_stages:ingest"})
    (project.root / "pipeline" / "ablations.yaml").write_text("variants: {other: {changes: {mesh: {unused: 1}}}}\n")
    project.run()
    record = place(project.home, project.graph.nodes["other/model"], "towel").record()
    assert record["facts"]["same_work_as"] == "model/towel"
    assert record["parts"]["made_from"].keys() == {"mesh:other/mesh/towel"}
    (project.root / "pipeline" / "ablations.yaml").write_text(
        "variants: {other: {changes: {mesh: {unused: 1}, model: {width: 3}}}}\n"
    )
    project.run()
    assert "same_work_as" not in place(project.home, project.graph.nodes["other/model"], "towel").record()["facts"]


def test_selected_stages_and_garments_alone_are_made(project):
    report = project.run(nodes={"scan", "mesh"}, garments=["towel"])
    assert sorted(report.made) == ["mesh/towel", "scan/towel"]


class Companions:
    """Notes which stages are ever under way beside each other."""

    def __init__(self):
        self.under_way, self.pairs = [], set()

    def plan(self, seconds_left, count_left): ...
    def progress(self, name, done, total, what): ...

    def started(self, name):
        stage = name.split("/")[0]
        self.pairs |= {frozenset((stage, other)) for other in self.under_way}
        self.under_way.append(stage)

    def finished(self, name, seconds, message):
        self.under_way.remove(name.split("/")[0])


def test_stages_of_one_pool_run_one_at_a_time_and_beside_them_whatever_is_of_no_pool_or_another(project):
    project.stages(mesh={"pool": "x"}, model={"needs": ["scan"], "pool": "x"}, dataset={"needs": ["scan"], "pool": "y"})
    seen = Companions()
    report = project.run(jobs=2, nodes={"scan", "mesh", "model", "dataset"}, observer=seen)
    assert len(report.made) == 7
    assert not report.failed
    # Both scans can begin at once. When the second is made, `dataset` can begin, and so can its mesh and its model.
    assert frozenset({"scan"}) in seen.pairs
    assert {frozenset({"dataset", "mesh"}), frozenset({"dataset", "model"})} & seen.pairs
    assert not {frozenset({"mesh"}), frozenset({"model"}), frozenset({"mesh", "model"})} & seen.pairs


@pytest.fixture
def updating(made):
    """A home in which `model` writes a page for every word of a book, and was made of three words."""
    book = made.root / "data" / "book.txt"
    book.write_text("a b c")
    change = {"run": "toy_stages:pages", "sources": {"book": "data/book.txt"}, "updates": True, "resumes": True}
    made.stages(model=change)
    made.run()
    return made, book, change


def written(project) -> int:
    """How many pages the last making of the towel's model wrote."""
    return place(project.home, project.graph.nodes["model"], "towel").record()["facts"]["written"]


def test_a_stage_that_updates_begins_with_the_artifact_that_it_replaces(updating):
    project, book, _ = updating
    assert written(project) == 3
    old = place(project.home, project.graph.nodes["model"], "towel").record()
    whole_s, before_files = old["whole_s"], {name: known["sha256"] for name, known in old["files"].items()}
    before = project.events()
    book.write_text("a c d")
    project.run()
    assert changed_since(project, before) == ["model/shirt", "model/towel", "dataset", "report"]
    assert written(project) == 1
    node = project.graph.nodes["model"]
    # What was kept, two pages of the three (and no other file), took its share of the time; the new one what it took now.
    record = place(project.home, node, "towel").record()
    kept = sum(before_files.get(name) == known["sha256"] for name, known in record["files"].items())
    assert 0 < kept < len(before_files)
    spent_s = record["whole_s"] - whole_s * kept / len(before_files)
    assert 0 < spent_s <= record["seconds"]
    assert sorted(file.name for file in place(project.home, node, "towel").final.glob("*.txt")) == [
        "a.txt",
        "c.txt",
        "d.txt",
    ]
    with project.instance() as instance:
        snapshot = Snapshot(instance, project.graph, project.home)
        assert {snapshot.status(node, key).state for node, key in snapshot.artifacts()} == {"fresh"}


def test_a_stage_that_updates_begins_anew_after_damage_or_with_another_version(updating):
    project, book, change = updating
    (place(project.home, project.graph.nodes["model"], "towel").final / "a.txt").write_text("scribble")
    project.run()
    assert written(project) == 3
    project.stages(model={**change, "version": 2})
    project.run()
    assert written(project) == 3
    book.write_text("a b c d")
    project.run()
    assert written(project) == 1


def test_a_stage_that_updates_goes_on_from_what_failed_its_check(updating):
    project, book, _ = updating
    at = place(project.home, project.graph.nodes["model"], "towel")
    good = at.record()
    book.write_text("a b c d e invalid")
    assert "failed its checks: is_valid" in project.run().failed["model/towel"]
    assert at.record() == good
    book.write_text("a b c d e f")
    assert not project.run().failed
    assert written(project) == 1
    assert not at.rejected.exists()


def test_what_failed_its_check_is_no_beginning_where_somebody_changed_it_or_with_another_version(updating):
    project, book, change = updating
    at = place(project.home, project.graph.nodes["model"], "towel")
    book.write_text("a b c d e invalid")
    project.run()
    (at.rejected / "d.txt").write_text("scribble")
    book.write_text("a b c d e")
    assert not project.run().failed
    assert written(project) == 2  # of the artifact's three
    book.write_text("a b c d e f invalid")
    project.run()
    project.stages(model={**change, "version": 2})
    book.write_text("a b c d e f")
    project.run()
    assert written(project) == 6


def test_a_stage_that_updates_and_is_killed_leaves_the_artifact_as_it_was_and_goes_on(updating, tmp_path):
    project, book, change = updating
    at = place(project.home, project.graph.nodes["model"], "towel")
    good, marker = at.record(), tmp_path / "mended"
    project.stages(model={**change, "config": {"die_unless": str(marker)}})
    book.write_text("b c d e")
    assert "model/towel" in project.run(jobs=1, nodes={"model"}, garments=["towel"]).failed
    assert at.record() == good
    assert at.damage(good, thorough=True) is None
    marker.write_text("")
    project.run(nodes={"model"}, garments=["towel"])
    assert written(project) == 0  # the killed run had written both


def test_two_runs_at_once_are_refused(project):
    from assets_defs._regenerate import _alone
    from assets_defs._store import StoreError

    with _alone(project.home), pytest.raises(StoreError, match=r"process \d+ is regenerating already"):
        project.run()
