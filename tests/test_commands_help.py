"""Every command explains itself."""

import pytest
import typer.main
from typer.testing import CliRunner

from assets_defs.cli import app


def commands(group, words=()):
    """Words that lead to each command and group."""
    yield words
    for name, command in getattr(group, "commands", {}).items():
        yield from commands(command, (*words, name))


@pytest.mark.parametrize("words", list(commands(typer.main.get_command(app))), ids=" ".join)
def test_help_is_printed_and_says_how_to_use_it(words):
    said = CliRunner().invoke(app, [*words, "--help"])
    assert said.exit_code == 0, said.output
    assert "Usage:" in said.output
