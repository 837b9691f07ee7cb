"""`python -m benchmarks.diagnosis run|table|at-truth`: bundles of `benchmarks.concealed` (a stand-in for reality), diagnosed and compared."""

from pathlib import Path
from typing import Annotated

import typer

from benchmarks.diagnosis.at_truth import at_truth
from benchmarks.diagnosis.tables import tables
from benchmarks.diagnosis.trial import Trial, run_trial

app = typer.Typer(add_completion=False, no_args_is_help=True, help=__doc__)
Out = Annotated[Path, typer.Option(help="JSON lines, one a case; cases that are there stay")]


@app.command()
def run(
    cases: Annotated[list[Path], typer.Argument(help="folders with bundle/ and answers.json")],
    out: Out = Path("diagnoses.jsonl"),
) -> None:
    """Diagnose cases one after the other; one that fails is told and does not stop the others."""
    done = {trial.case for trial in _read(out)}
    failed = 0
    for folder in cases:
        if folder.name in done:
            continue
        try:
            trial = run_trial(folder)
        except Exception as error:  # whatever it is, the other cases go on
            failed += 1
            typer.echo(f"{folder.name}: FAILED: {type(error).__name__}: {error}")
            continue
        with out.open("a") as file:
            file.write(trial.model_dump_json() + "\n")
        names = ", ".join(trial.named) or "-"
        typer.echo(f"{trial.case}: {trial.verdict} {names}, {trial.seconds:.0f} s{'' if trial.right else '  <- wrong'}")
    if failed:
        raise typer.Exit(1)


@app.command()
def table(out: Out = Path("diagnoses.jsonl")) -> None:
    """Print what was found, in Markdown."""
    typer.echo(tables(_read(out)))


@app.command("at-truth")
def compare_at_truth(
    cases: Annotated[list[Path], typer.Argument(help="folders with bundle/ and answers.json")],
) -> None:
    """Print what is left of the recordings at the true parameters: free runs and pulled ones, two meshes."""
    for folder in cases:
        typer.echo(at_truth(folder) + "\n")


def _read(path: Path) -> list[Trial]:
    if not path.exists():
        return []
    return [Trial.model_validate_json(line) for line in path.read_text().splitlines()]


if __name__ == "__main__":
    app()
