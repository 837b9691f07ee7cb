"""The laboratory is called by a command that a list can hold on any machine."""

import sys
from pathlib import Path

from sim1.proof.laboratory import Laboratory

REPOSITORY = Path(__file__).parents[2]


def test_python_is_the_one_that_runs_this_and_other_commands_are_taken_as_they_are():
    assert Laboratory(command=("python", "-m", "lab"), home=REPOSITORY).argv == (sys.executable, "-m", "lab")
    assert Laboratory(command=("./lab", "python"), home=REPOSITORY).argv == ("./lab", "python")


def test_this_projects_laboratory_lists_the_table_and_what_is_outside():
    table, outside = Laboratory(command=("python", "-m", "benchmarks.concealed"), home=REPOSITORY).effects()
    assert (len(table), len(outside)) == (21, 10)
