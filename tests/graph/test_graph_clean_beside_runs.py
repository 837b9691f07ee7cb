"""`sim1 clean` takes nothing from who is at work: a regeneration keeps it out, a run from the UI keeps its artifact."""

from assets_defs._clean import clean, doomed
from assets_defs._store import alone, place


def files_of(project) -> set[str]:
    return {path.relative_to(project.root).as_posix() for path in project.root.rglob("*")}


def half_made(project, stage="mesh"):
    """The place of the towel's artifact, with what a process that makes it anew has beside it so far."""
    at = place(project.home, project.graph.nodes[stage], "towel")
    at.begin("some recipe", resume=False)
    return at


def test_clean_is_refused_while_a_regeneration_is_under_way(made):
    half_made(made)
    before = files_of(made)
    with alone(made.home):
        for options in ([], ["--all"]):
            answer = made.command("clean", "--yes", *options)
            assert answer.returncode == 2
            assert "is regenerating already" in answer.stderr
    assert files_of(made) == before


def test_a_regeneration_is_refused_while_the_question_of_clean_is_open(made, monkeypatch):
    half_made(made)
    said = []

    def asked(question):
        said.append(made.command("run", "--jobs", "0").stdout)
        return True

    monkeypatch.setattr("typer.confirm", asked)
    assert made.command("clean").returncode == 0
    assert "or cleaning; wait for it or stop it" in said[0]


def test_clean_leaves_alone_what_a_run_from_the_ui_is_making_and_says_so(made):
    at, other = half_made(made), half_made(made, "model")
    with at.locked():
        answer = made.command("clean", "--yes")
        assert answer.returncode == 0, answer.stderr
        assert "left alone: data/store/mesh/towel: process " in answer.stdout
        assert at.part.is_dir()
        assert at.lock.is_file()
        assert not other.part.exists()
        assert not other.lock.exists()
        assert made.command("clean", "--garment", "towel", "--yes").returncode == 0
        assert at.record()
        assert not other.record()
    assert made.command("clean", "--yes").returncode == 0
    assert not at.part.exists()
    assert not at.lock.exists()
    assert at.record()


def test_what_a_process_begins_to_make_between_question_and_answer_is_left_alone_too(made):
    at = half_made(made)
    paths, held = doomed(made.home, made.graph, everything=False, garments=None, stages=None)
    assert at.part in paths
    assert held == []
    with at.locked():
        clean(made.home, paths)
        assert at.part.is_dir()
        assert at.lock.is_file()


def test_clean_of_everything_is_refused_while_an_artifact_is_being_made(made):
    at = half_made(made)
    before = files_of(made)
    with at.locked():
        answer = made.command("clean", "--all", "--yes")
        assert answer.returncode == 2
        assert "data/store/mesh/towel: process " in answer.stderr
    assert files_of(made) == before


def test_clean_brings_back_an_artifact_whose_writer_was_killed_between_its_two_renames(made):
    at = place(made.home, made.graph.nodes["mesh"], "towel")
    good = at.record()
    at.final.rename(at.old)
    assert made.command("clean", "--yes").returncode == 0
    assert at.record() == good
