"""`sim1 prove` as it is typed."""

import json
import shlex
import shutil
import sys

from proof_stand_ins import notes, write_programs
from typer.testing import CliRunner

from assets_defs.cli import app
from benchmarks.concealed.effects.library import LIBRARY
from pipeline.home import REPOSITORY


def prove(*words):
    return CliRunner().invoke(app, ["prove", *map(str, words)])


def test_without_a_campaign_it_asks_what_to_draw(tmp_path):
    said = prove("--out", tmp_path / "out")
    assert said.exit_code == 2
    assert "say how many cases to draw (--cases 60)" in said.output
    said = prove("--report", "--out", tmp_path / "out")
    assert said.exit_code == 2
    assert "begin a campaign with" in said.output


def test_a_command_films_commits_and_starts_the_real_diagnosis_which_refuses_a_bundle_that_is_none(tmp_path):
    laboratory = write_programs(tmp_path)["laboratory"]
    (tmp_path / "cases.yaml").write_text("- {effects: [none], seed: 7}\n")
    words = ("--cases-file", tmp_path / "cases.yaml", "--laboratory", shlex.join(laboratory), "--out", tmp_path / "out")
    said = prove(*words, "--only-films")
    assert said.exit_code == 0
    printed = [line.split() for line in said.output.splitlines()]
    for line in (tmp_path / "out" / "commitments.jsonl").read_text().splitlines():
        for hashed in json.loads(line)["sha256"].values():
            assert any(hashed in [word.rstrip(",") for word in words] for words in printed)
    said = prove("--out", tmp_path / "out")
    assert said.exit_code == 0
    assert "0 of 1 (95 % interval" in said.output
    proof = json.loads((tmp_path / "out" / "proof.json").read_text())
    assert proof["outcomes"][0]["verdict"] == "failed"
    assert "bundle.yaml" in proof["outcomes"][0]["error"]
    asked = prove("--baselines", "--out", tmp_path / "out")
    assert asked.exit_code == 0  # of a diagnosis that failed nobody is asked anything
    assert not (tmp_path / "out" / "baselines").exists()
    assert len(notes(tmp_path, "laboratory")) == 1
    again = prove(*words)
    assert again.exit_code == 2
    assert "leave out --cases-file, --laboratory" in again.output


def test_an_interruption_says_how_to_go_on_with_what_was_asked(tmp_path, monkeypatch):
    laboratory = write_programs(tmp_path)["laboratory"]
    (tmp_path / "cases.yaml").write_text("- {effects: [none], seed: 7}\n")
    out = tmp_path / "out"
    prove("--cases-file", tmp_path / "cases.yaml", "--laboratory", shlex.join(laboratory), "--out", out, "--only-films")

    def interrupted(*given):
        raise KeyboardInterrupt

    monkeypatch.setattr("sim1.proof.oracle.ask_oracle", interrupted)
    said = prove("--oracle", "--out", out)
    assert said.exit_code == 130
    assert f"`sim1 prove --oracle --out {out}` goes on" in said.output
    assert not (out / "found").exists()


def test_a_seed_that_draws_what_set_the_thresholds_is_refused_and_nothing_is_begun(tmp_path):
    stored = json.loads((REPOSITORY / "docs" / "campaign" / "along" / "answers" / "drawn.json").read_text())
    listed = [f"{name} {'table' if recipe.in_table else 'outside'}" for name, recipe in LIBRARY.items()]
    (tmp_path / "lists.py").write_text(f"print({chr(10).join(listed)!r})")  # as the laboratory does, without what films
    laboratory = shlex.join((sys.executable, str(tmp_path / "lists.py")))
    said = prove("--cases", 60, "--seed", stored["seed"], "--laboratory", laboratory, "--out", tmp_path / "out")
    assert said.exit_code == 2
    words = " ".join(said.output.split())
    assert f"--seed {stored['seed']}: draws nothing concealed with seed 777156727 (20 such), a case by which" in words
    assert "thresholds.yaml was set, so that it proves nothing; give another --seed or none." in words
    assert not (tmp_path / "out" / "answers").exists()


def test_chosen_cases_may_be_those_of_the_thresholds_which_are_set_anew_by_them(tmp_path):
    laboratory = write_programs(tmp_path)["laboratory"]
    (tmp_path / "cases.yaml").write_text("- {effects: [none], seed: 777156727}\n")
    words = ("--cases-file", tmp_path / "cases.yaml", "--laboratory", shlex.join(laboratory), "--out", tmp_path / "out")
    assert prove(*words, "--only-films").exit_code == 0


def test_thresholds_are_set_by_a_campaign_that_they_rest_on_already(tmp_path, monkeypatch):
    monkeypatch.setattr("sim1.proof.calibrate.RESAMPLES", 5)
    shutil.copytree(REPOSITORY / "docs" / "campaign" / "along", tmp_path / "out")
    said = prove("--calibrate", "--out", tmp_path / "out")
    assert said.exit_code == 0, said.output
    assert "20 cases with nothing concealed" in said.output
    assert (tmp_path / "out" / "thresholds.yaml").is_file()
