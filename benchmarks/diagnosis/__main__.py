"""`python -m benchmarks.diagnosis at-truth CASE...`: what a simulation leaves of the recordings of `benchmarks.concealed` at the true parameters."""

from pathlib import Path
from typing import Annotated

import typer

from benchmarks.diagnosis.at_truth import at_truth

app = typer.Typer(add_completion=False, no_args_is_help=True, help=__doc__)


@app.callback()
def _named() -> None:
    """Keep the command's name, which typer drops where there is one alone."""


@app.command("at-truth")
def compare_at_truth(
    cases: Annotated[list[Path], typer.Argument(help="folders with bundle/ and answers.json")],
) -> None:
    """Print what is left of the recordings at the true parameters: free runs and pulled ones, two meshes."""
    for folder in cases:
        typer.echo(at_truth(folder) + "\n")


if __name__ == "__main__":
    app()
