"""The command line: status, audit, clean, and errors as one line."""

import json
import shutil
from pathlib import Path

import pytest

from assets_defs._audit import print_audit
from assets_defs._clean import clean
from assets_defs._sources import faults
from assets_defs._status import print_status


def test_status_tells_fresh_from_stale_and_why(project):
    rows = json.loads(project.command("status", "--json").stdout)["artifacts"]
    assert {row["state"] for row in rows} == {"missing"}
    project.run()
    project.add_garment("towel", "point 0 0 5")
    rows = json.loads(project.command("status", "--json").stdout)["artifacts"]
    by_name = {(row["asset"], row["garment"]): row for row in rows}
    assert by_name["scan", "towel"] == {
        "asset": "scan",
        "garment": "towel",
        "state": "stale",
        "why": "source scans changed",
    }
    assert by_name["dataset", None]["state"] == "waiting"
    assert by_name["model", "shirt"]["state"] == "fresh"
    assert "scan/towel: source scans changed" in project.command("status").stdout


def test_status_cuts_no_name_at_80_columns(project, monkeypatch, capsys):
    (project.root / "pipeline" / "ablations.yaml").write_text(
        "variants: {a_variant_with_quite_a_long_name: {changes: {model: {width: 9}}}}\n"
    )
    names = [f"garment-{number}" for number in range(7)]
    for name in names:
        project.add_garment(name)
    monkeypatch.setenv("COLUMNS", "80")
    print_status(project.home, project.graph, as_json=False)
    answer = capsys.readouterr().out
    lines = answer.splitlines()
    assert all(len(line) <= 80 for line in lines)
    assert all(name in answer for name in [*names, "shirt", "towel", "joint", "a_variant_with_quite_a_long_name"])
    assert sum(line.split().count("·") for line in lines[1:]) == 2 + 9 * 3 + 1 + 9  # all missing, none twice
    assert "✓ fresh  ~ stale  · missing  … waiting  ✗ failed" in lines[0]


def test_audit_lists_every_ancestor_with_version_config_and_data(project):
    (project.root / "pipeline" / "ablations.yaml").write_text("variants: {wide: {changes: {model: {width: 9}}}}\n")
    project.stages(model={"config": {"seed": 7}})
    project.run()
    found = json.loads(project.command("audit", "dataset", "--json").stdout)["ancestry"]
    assert set(found) == {
        "dataset",
        *(f"{stage}/{g}" for stage in ("scan", "mesh", "model") for g in ("shirt", "towel")),
    }
    assert found["model/towel"]["seed"] == 7
    assert found["dataset"]["made_from"]["model:model/towel"] == found["model/towel"]["data_version"]
    assert set(found["scan/towel"]["sources"]) == {"garment", "scans"}
    rows = json.loads(project.command("audit", "dataset", "--against", "wide", "--json").stdout)["rows"]
    assert {row["artifact"] for row in rows} == {"dataset", "model/shirt", "model/towel"}
    assert {"width": [None, 9]} in [row["settings"] for row in rows]
    assert {row["content"] for row in rows} == {"differs"}
    assert "model/towel" in project.command("audit", "dataset").stdout
    answer = project.command("audit", "datset")
    assert answer.returncode == 2
    assert "datset: no such asset" in answer.stderr


def test_audit_against_a_variant_keeps_equal_content_apart_from_differences(project, capsys):
    # Comments do not count in what `ingest` writes, so both variants of `mesh` give the same artifact.
    project.stages(mesh={"run": "toy_stages:ingest"})
    (project.root / "pipeline" / "ablations.yaml").write_text(
        "variants: {other: {changes: {mesh: {unused: 1}, dataset: {size: 2}}}}\n"
    )
    project.run()
    print_audit(project.home, project.graph, "dataset", "other", as_json=True)
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert {row["artifact"]: row["content"] for row in rows} == {
        "dataset": "differs",
        "mesh/towel": "same",
        "mesh/shirt": "same",
        "model/towel": "same",
        "model/shirt": "same",
    }
    print_audit(project.home, project.graph, "dataset", "other", as_json=False)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "dataset against other/dataset: the content of 1 artifacts differs"
    assert lines[1].startswith("  dataset: ")
    assert lines[1].endswith("  size: None -> 2")
    assert lines[2] == "4 more have another recipe and the same content:"
    assert "  mesh/towel  unused: None -> 1" in lines[3:]


def test_audit_shows_the_parents_that_an_artifact_was_made_from_even_when_they_changed_since(made):
    before = json.loads(made.command("audit", "dataset", "--json").stdout)["ancestry"]
    made.add_garment("towel", "point 3 3 3")
    made.run(nodes={"scan", "mesh"})
    after = json.loads(made.command("audit", "dataset", "--json").stdout)["ancestry"]
    assert after == before


def test_run_prints_what_it_made_and_fails_with_its_exit_code(project):
    answer = project.process("run", "--jobs", "1", "--select", "mesh", "--garment", "towel")
    assert answer.returncode == 0, answer.stderr
    assert "2 made" in answer.stdout
    project.add_garment("towel", "bad")
    project.stages(mesh={"config": {"no_space": True}})
    answer = project.process("run")
    assert answer.returncode == 1
    # Said once, with the artifact's name once, and paths as a person would type them.
    assert [line for line in answer.stdout.splitlines() if "something else" in line] == [
        "failed scan/towel: scan.txt: line 1: bad (got 'bad'); write something else"
    ]
    assert "failed mesh/shirt: the disk is full: data/store/mesh/shirt.part/content.txt" in answer.stdout
    assert str(project.root) not in answer.stdout + answer.stderr
    assert "failed scan/towel: scan.txt: line 1" in project.command("status").stdout


def test_a_fault_in_a_file_of_the_person_ends_the_run_before_any_work(project):
    for name in ("towel", "shirt"):
        with (project.root / "data" / "garments" / f"{name}.yaml").open("a") as file:
            file.write("broken: true\n")
    (project.root / "data" / "scans" / "towel" / "scan.txt").unlink()
    (project.root / "data" / "scans" / "towel").rmdir()
    answer = project.command("run", "--jobs", "0")
    assert answer.returncode == 2
    assert answer.stdout == ""
    assert answer.stderr.splitlines()[1:] == [
        "  data/garments/shirt.yaml: key 'broken' is unknown",
        "  data/garments/towel.yaml: key 'broken' is unknown",
        "  data/scans/towel: missing; stage scan needs it (its source 'scans')",
    ]
    assert project.events() == []
    project.add_garment("shirt")
    assert "2 made" in project.command("run", "--jobs", "0", "--garment", "shirt", "--select", "mesh").stdout


def test_every_fault_is_listed_once_and_only_of_what_is_asked_for(project):
    graph = project.graph
    assert faults(project.home, graph, set(graph.nodes), None) == []
    (project.root / "data" / "scans" / "towel" / "scan.txt").unlink()
    (project.root / "data" / "scans" / "towel").rmdir()
    said = "data/scans/towel: missing; stage scan needs it (its source 'scans')"
    assert faults(project.home, graph, set(graph.nodes), None) == [said]
    assert faults(project.home, graph, set(graph.nodes), ["shirt"]) == []
    assert faults(project.home, graph, {"mesh"}, ["towel"]) == []


def test_only_a_run_of_everything_changes_the_profile_of_later_commands(made, monkeypatch):
    monkeypatch.delenv("SIM1_PROFILE")
    (made.root / "pipeline" / "profiles" / "smoke.yaml").write_text("mesh: {width: 1}\n")

    def profile_in_force() -> str:
        return json.loads(made.command("status", "--json").stdout)["profile"]

    answer = made.command("run", "--profile", "smoke", "--garment", "towel", "--select", "mesh", "--jobs", "0")
    assert "1 made" in answer.stdout
    assert "profile smoke was for this part alone: without --profile, commands keep to quick" in answer.stdout
    assert profile_in_force() == "quick"
    answer = made.command("run", "--profile", "smoke", "--jobs", "0")
    assert "for this part alone" not in answer.stdout
    assert profile_in_force() == "smoke"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "--profile", "quik"], "profile 'quik' does not exist"),
        (["run", "--garment", "sock"], "there is no data/garments/sock.yaml"),
        (["run", "--select", "mehs"], "--select mehs: there is no such stage"),
        (["run", "--variant", "wide"], "--variant wide"),
    ],
)
def test_a_wrong_option_is_one_line_with_the_choices(project, arguments, said):
    answer = project.command(*arguments)
    assert answer.returncode == 2
    assert said in answer.stderr
    assert "Traceback" not in answer.stderr


def test_without_dagster_yaml_the_command_refuses(project):
    (project.root / "dagster.yaml").unlink()
    answer = project.command("status")
    assert answer.returncode == 2
    assert "throw-away instance" in answer.stderr


def test_clean_removes_leftovers_and_orphans_and_nothing_else(made):
    store = made.home.store
    (store / "mesh" / "towel.part").mkdir()
    (store / "mesh" / "sock").mkdir()
    (store / "gone_stage" / "towel").mkdir(parents=True)
    answer = made.command("clean", "--yes")
    assert answer.returncode == 0, answer.stderr
    assert not (store / "mesh" / "towel.part").exists()
    assert not (store / "mesh" / "sock").exists()
    assert not (store / "gone_stage" / "towel").exists()
    assert made.run().made == {}
    assert made.command("clean", "--select", "model", "--garment", "towel", "--yes").returncode == 0
    assert list(made.run().made) == ["model/towel"]


def files(root: Path) -> set[str]:
    return {path.relative_to(root).as_posix() for path in root.rglob("*") if path.is_file()}


@pytest.mark.parametrize("typed", ["n\n", "\n"])
def test_clean_removes_nothing_where_the_answer_is_not_yes(made, typed):
    before = files(made.root)
    answer = made.command("clean", "--all", typed=typed)
    assert answer.returncode == 1
    assert "  data/store\n  .dagster\nRemove these 2?" in answer.stdout
    assert "removed" not in answer.stdout
    assert files(made.root) == before


def test_clean_of_everything_leaves_what_a_person_wrote(made):
    before = files(made.root)
    answer = made.command("clean", "--all", "--yes")
    assert answer.returncode == 0, answer.stderr
    assert not made.home.store.exists()
    assert not made.home.state.exists()
    assert files(made.root) == {name for name in before if not name.startswith(("data/store/", ".dagster/"))}
    assert {"data/garments/towel.yaml", "data/scans/towel/scan.txt", "dagster.yaml"} <= files(made.root)
    assert "nothing to remove" in made.command("clean", "--all", "--yes").stdout


def with_variants(project, *names: str) -> None:
    """Put artifacts of `model` that are like the base's into the store."""
    for name in names:
        shutil.copytree(project.home.store / "model", project.home.store / "variants" / name / "model")


def test_clean_removes_a_variant_that_is_no_more_and_keeps_the_others(made):
    (made.root / "pipeline" / "ablations.yaml").write_text("variants: {kept: {changes: {model: {width: 9}}}}\n")
    made.command("clean", "--yes")  # lock files
    with_variants(made, "kept")
    before = files(made.root)
    with_variants(made, "gone")
    answer = made.command("clean", typed="y\n")
    assert answer.returncode == 0, answer.stderr
    assert [line for line in answer.stdout.splitlines() if line.startswith("  ")] == [
        f"  data/store/variants/gone/model/{name}" for name in ("shirt", "towel")
    ]
    assert files(made.root) == before


def test_clean_of_a_garment_takes_its_artifacts_of_all_stages_and_variants_and_no_others(made):
    (made.root / "pipeline" / "ablations.yaml").write_text("variants: {kept: {changes: {model: {width: 9}}}}\n")
    made.command("clean", "--yes")  # lock files
    with_variants(made, "kept")
    before = files(made.root)
    answer = made.command("clean", "--garment", "towel", "--yes")
    assert answer.returncode == 0, answer.stderr
    gone = tuple(f"data/store/{stage}/towel/" for stage in ("scan", "mesh", "model", "variants/kept/model"))
    assert all(any(name.startswith(folder) for name in before) for folder in gone)
    assert files(made.root) == {name for name in before if not name.startswith(gone)}


def test_clean_of_a_garment_that_nobody_knows_is_refused(made):
    before = files(made.root)
    answer = made.command("clean", "--garment", "twoel", "--yes")
    assert answer.returncode != 0
    assert "--garment twoel: there is no such garment" in answer.stderr
    assert files(made.root) == before


@pytest.mark.parametrize("outside", ["data/garments", "data", "."])
def test_what_lies_outside_store_and_state_is_never_removed(made, outside):
    before = files(made.root)
    with pytest.raises(ValueError, match=r"not below .*data/store"):
        clean(made.home, [made.root / outside])
    assert files(made.root) == before


def test_a_fault_in_the_files_of_looks_is_one_line_before_anything_is_rendered(project):
    answer = project.command("looks", "--out", "pictures")
    assert answer.returncode == 2
    assert "sim1: data/appearance/fabrics.yaml: cannot be read" in answer.stderr
    assert not (project.root / "pictures").exists()
