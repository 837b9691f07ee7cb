"""Bad input, damage, a full disk and killed processes: a clear error, and no good artifact lost."""

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time

import pytest

from assets_defs import _store
from assets_defs._recipe import Snapshot
from assets_defs._store import StoreError, place, verified


def test_bad_input_names_the_fault_and_keeps_the_good_artifact(made):
    good = place(made.home, made.graph.nodes["scan"], "towel").record()
    made.add_garment("towel", "bad")
    report = made.run()
    assert report.failed["scan/towel"] == "scan.txt: line 1: bad (got 'bad'); write something else"
    assert report.waiting.keys() == {"mesh/towel", "model/towel", "dataset", "report"}
    assert place(made.home, made.graph.nodes["scan"], "towel").record() == good
    status = json.loads(made.command("status", "--json").stdout)
    states = {(row["asset"], row["garment"]): row for row in status["artifacts"]}
    assert states["scan", "towel"]["state"] == "failed"
    assert "something else" in states["scan", "towel"]["why"]
    made.add_garment("towel", "point 0 0 0")
    assert not made.run().failed


def test_an_artifact_that_fails_its_check_is_kept_out_of_the_store(made):
    node = made.graph.nodes["mesh"]
    good = place(made.home, node, "towel").record()
    made.stages(mesh={"config": {"invalid": True}})
    report = made.run()
    assert "failed its checks: is_valid" in report.failed["mesh/towel"]
    assert place(made.home, node, "towel").record() == good
    assert place(made.home, node, "towel").rejected.is_dir()
    assert "dataset" in report.waiting


@pytest.mark.parametrize("damage", ["truncate", "append", "edit", "delete", "extra", "record"])
def test_a_damaged_artifact_is_noticed_and_made_again(made, damage):
    at = place(made.home, made.graph.nodes["mesh"], "towel")
    file = at.final / "content.txt"
    match damage:
        case "truncate":
            file.write_bytes(file.read_bytes()[:10])
        case "append":
            file.write_bytes(file.read_bytes() + b"x")
        case "edit":
            file.write_bytes(b"y" + file.read_bytes()[1:])
        case "delete":
            file.unlink()
        case "extra":
            (at.final / "stray.txt").write_text("?")
        case "record":
            (at.final / "artifact.json").write_text("{")
    with pytest.raises(StoreError, match=r"sim1 run --select mesh --garment towel"):
        verified(made.home, made.graph.nodes["mesh"], "towel")
    assert list(made.run().made) == ["mesh/towel"]
    verified(made.home, made.graph.nodes["mesh"], "towel")


def test_a_full_disk_is_named_and_costs_nothing(made):
    good = place(made.home, made.graph.nodes["mesh"], "towel").record()
    made.stages(mesh={"config": {"no_space": True}})
    report = made.run()
    assert "the disk is full" in report.failed["mesh/towel"]
    assert "free some space" in report.failed["mesh/towel"]
    assert place(made.home, made.graph.nodes["mesh"], "towel").record() == good


def test_a_worker_that_is_killed_fails_its_own_artifact_alone(project, tmp_path):
    marker = tmp_path / "mended"
    project.stages(mesh={"config": {"die_unless": str(marker)}})
    report = project.run(jobs=1, nodes={"scan", "mesh"}, garments=["towel"])
    assert "killed (out of memory?)" in report.failed["mesh/towel"]
    assert list(report.made) == ["scan/towel"]
    marker.write_text("")
    report = project.run(jobs=1, nodes={"scan", "mesh"}, garments=["towel"])
    assert list(report.made) == ["mesh/towel"]


def test_a_fault_that_nobody_foresaw_is_noted_like_any_other(made):
    good = place(made.home, made.graph.nodes["mesh"], "towel").record()
    made.stages(mesh={"config": {"raises": True}})
    made.run(garments=["towel"])
    at = place(made.home, made.graph.nodes["mesh"], "towel")
    assert at.failed()["message"] == "RuntimeError: data/store/mesh/towel.part: the library has a fault"
    with made.instance() as instance:
        assert Snapshot(instance, made.graph, made.home).status(made.graph.nodes["mesh"], "towel").state == "failed"
    assert at.record() == good


def test_the_seconds_of_all_tries_add_up_and_a_killed_one_leaves_them_unknown(project, tmp_path):
    for how, known in (({"raises": True}, True), ({}, False)):
        marker = tmp_path / f"mended {known}"
        config = {"die_unless": str(marker), "sleep_s": 0.2, **how}
        project.stages(mesh={"run": "toy_stages:frames", "resumes": True, "config": config})
        assert project.run(jobs=1, nodes={"scan", "mesh"}, garments=["towel"]).failed
        marker.write_text("")
        assert not project.run(nodes={"scan", "mesh"}, garments=["towel"]).failed
        record = place(project.home, project.graph.nodes["mesh"], "towel").record()
        if known:  # four files of 0.2 s, and the second once more
            assert record["whole_s"] > 0.8 > record["seconds"] - 0.8
            assert record["whole_s"] > record["seconds"] - 0.2
        else:
            assert record["whole_s"] is None


@pytest.mark.parametrize("resumes", [True, False])
def test_a_stage_that_resumes_goes_on_in_what_a_killed_run_left(project, tmp_path, resumes):
    marker = tmp_path / "mended"
    change = {"run": "toy_stages:frames", "resumes": resumes, "config": {"die_unless": str(marker)}}
    project.stages(mesh=change)
    assert project.run(jobs=1, nodes={"scan", "mesh"}, garments=["towel"]).failed
    marker.write_text("")
    assert not project.run(nodes={"scan", "mesh"}, garments=["towel"]).failed
    record = place(project.home, project.graph.nodes["mesh"], "towel").record()
    assert record["facts"] == {"written": 2 if resumes else 4}


def test_a_run_that_is_killed_goes_on_where_it_was(project):
    project.stages(model={"config": {"sleep_s": 30}})
    program = [sys.executable, "-c", "from assets_defs.cli import main; main()", "run", "--jobs", "1"]
    process = subprocess.Popen(program, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    part = place(project.home, project.graph.nodes["model"], "shirt").part
    deadline = time.monotonic() + 60
    while not part.exists() and time.monotonic() < deadline:
        time.sleep(0.1)
    assert part.exists()
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert place(project.home, project.graph.nodes["model"], "shirt").record() is None
    before = project.events()
    assert before == ["scan/shirt", "scan/towel", "mesh/shirt", "mesh/towel"]
    project.stages()
    report = project.run()
    assert sorted(report.made) == ["dataset", "model/shirt", "model/towel", "report"]
    with project.instance() as instance:
        snapshot = Snapshot(instance, project.graph, project.home)
        assert {snapshot.status(node, key).state for node, key in snapshot.artifacts()} == {"fresh"}
        running = [run for run in instance.get_runs() if not run.is_finished]
        assert running == []


def test_killed_between_the_two_renames_the_old_artifact_comes_back(made):
    at = place(made.home, made.graph.nodes["mesh"], "towel")
    good = at.record()
    at.final.rename(at.old)
    assert at.record() == good
    assert made.run().made == {}


def test_a_reader_between_the_two_renames_waits_for_the_writer_and_takes_nothing_from_it(made, monkeypatch):
    # A busy machine may keep the writer from its second rename for longer than readers are patient.
    monkeypatch.setattr(_store, "PATIENCE", 60 * _store.PATIENCE)
    at = place(made.home, made.graph.nodes["mesh"], "towel")
    good = at.record()
    shutil.copytree(at.final, at.part)
    seen, came = [], threading.Event()

    def read():
        came.set()
        seen.append(at.record())

    with at.locked():
        at.final.rename(at.old)
        reader = threading.Thread(target=read)
        reader.start()
        assert came.wait(30)
        reader.join(0.1)
        assert not seen
        at.part.rename(at.final)
        reader.join(30)
    assert seen == [good]
    assert at.old.is_dir()
