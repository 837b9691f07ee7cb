"""No option is silently without effect, and a command that is refused changes nothing."""

import pytest
from toy_home import REPOSITORY
from typer.testing import CliRunner

from assets_defs._run import selected
from assets_defs._store import alone
from assets_defs.cli import app


@pytest.fixture
def wide(project):
    """A home with a variant that has a model and a dataset of its own."""
    (project.root / "pipeline" / "ablations.yaml").write_text("variants: {wide: {changes: {model: {width: 9}}}}\n")
    return project


@pytest.mark.parametrize(
    ("variant", "select", "said"),
    [
        ("wide", "scan", "--select scan: --variant wide has no such stage of its own; it has ['dataset', 'model']"),
        ("base", "report", "it has ['dataset', 'mesh', 'model', 'scan']"),
        ("base", "wide/model", "--select wide/model: --variant base has no such stage"),
    ],
)
def test_a_stage_that_the_variant_does_not_have_is_refused(wide, variant, select, said):
    answer = wide.command("run", "--jobs", "0", "--variant", variant, "--select", select)
    assert answer.returncode == 2
    assert said in answer.stderr
    answer = wide.command("run", "--jobs", "0", "--variant", variant, "--select", "model", "--select", select)
    assert answer.returncode == 2  # one of two is no better


def test_a_variant_brings_its_own_stages_and_what_they_need(wide):
    graph = wide.graph
    assert selected(graph, ["model"], "wide") == {"scan", "mesh", "wide/model"}
    assert selected(graph, ["wide/model"], "wide") == {"scan", "mesh", "wide/model"}
    assert selected(graph, ["model"], None) == {"scan", "mesh", "model", "wide/model"}
    assert selected(graph, None, "base") == {"scan", "mesh", "model", "dataset"}
    assert selected(graph, None, None) == set(graph.nodes)


def test_a_run_that_is_refused_does_not_change_the_profile_of_later_commands(made, monkeypatch):
    monkeypatch.delenv("SIM1_PROFILE")
    (made.root / "pipeline" / "profiles" / "smoke.yaml").write_text("{}\n")
    with alone(made.home):
        answer = made.command("run", "--profile", "smoke", "--jobs", "0")
    assert answer.returncode == 2
    assert "is regenerating already" in answer.stdout
    assert made.home.remembered_profile() == "quick"
    assert made.command("run", "--profile", "smoke", "--jobs", "0").returncode == 0
    assert made.home.remembered_profile() == "smoke"


@pytest.mark.parametrize("has_own", [True, False])
def test_the_page_opens_in_a_home_that_has_no_workspace_file(project, monkeypatch, has_own):
    if has_own:
        (project.root / "workspace.yaml").write_text("load_from: []\n")
    started = []
    monkeypatch.setattr("os.execv", lambda program, words: started.append(words))
    project.command("ui")
    home = project.root if has_own else REPOSITORY
    assert started[0][started[0].index("-w") + 1] == str(home / "workspace.yaml")
    assert (home / "workspace.yaml").is_file()


def prove(*words):
    answer = CliRunner().invoke(app, ["prove", *map(str, words)])
    assert answer.exit_code == 2
    return " ".join(answer.stderr.split())


@pytest.mark.parametrize("mode", ["--report", "--oracle", "--baselines", "--calibrate"])
def test_what_says_how_cases_are_made_is_refused_where_none_is_made(tmp_path, mode):
    drawing = {
        "--cases": [60],
        "--cases-file": [tmp_path / "cases.yaml"],
        "--seed": [0],
        "--strength": ["weak"],
        "--laboratory": ["films"],
        "--parallel": [1],
        "--limit-minutes": [60.0],
        "--only-films": [],
    }
    for option, values in drawing.items():
        said = prove(mode, option, *values, "--out", tmp_path / "out")
        assert said.endswith(f"leave out {option}")
    said = prove(mode, "--seed", 1, "--cases", 60, "--parallel", 2, "--out", tmp_path / "out")
    assert "leave out --cases, --seed, --parallel" in said
    assert not (tmp_path / "out").exists()


def test_a_campaign_whose_cases_would_count_twice_is_refused(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "out")
    for others in (["out"], ["link"], ["one", "one"], ["one", "two/../one"]):
        words = [word for name in others for word in ("--with", tmp_path / name)]
        assert "the cases of a campaign count once" in prove("--calibrate", "--out", tmp_path / "out", *words)
    assert "begin a campaign with" in prove("--calibrate", "--out", tmp_path / "out", "--with", tmp_path / "one")
