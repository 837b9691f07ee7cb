"""`python -m benchmarks.diagnosis at-truth|cost|separate|ablate|placebo`: the simulator at the truth, seconds, recordings that settle a doubt, parts left out, effects that mean nothing."""

from pathlib import Path
from typing import Annotated

import typer

from benchmarks.diagnosis.ablation import ablation
from benchmarks.diagnosis.at_truth import at_truth
from benchmarks.diagnosis.cost import cost
from benchmarks.diagnosis.placebo import placebos
from benchmarks.diagnosis.separating import separate

CASES = "folders with bundle/ and answers.json, or DIR/bundles/CASE of a campaign whose answers are open"
app = typer.Typer(add_completion=False, no_args_is_help=True, help=__doc__)


@app.command("at-truth")
def compare_at_truth(
    cases: Annotated[list[Path], typer.Argument(help=CASES)],
    steps_per_s: Annotated[float, typer.Option(min=30, help="of every simulation; predictions have 240")] = 240,
) -> None:
    """Print what is left of the recordings at the true parameters: free runs and pulled ones, three meshes."""
    for folder in cases:
        typer.echo(at_truth(folder, 1 / steps_per_s) + "\n")


@app.command("cost")
def diagnosis_cost(bundles: Annotated[list[Path], typer.Argument(help="folders of bundles")]) -> None:
    """Diagnose bundles and print where the seconds go."""
    typer.echo(cost(bundles))


@app.command("separate")
def separate_names(
    effect: Annotated[str, typer.Argument(help="concealed")],
    out: Annotated[Path, typer.Option(help="folder for films and findings")],
    motion: Annotated[list[str], typer.Option(help="filmed in both bundles; repeat it")],
    adding: Annotated[list[str], typer.Option(help="filmed in the second one as well; repeat it")],
    strength: str = "medium",
    seed: int = 0,
) -> None:
    """Diagnose the same cloth without and with the recording that a report asks for."""
    typer.echo(separate(effect, strength, seed, tuple(motion), tuple(adding), out))


@app.command("ablate")
def ablate_parts(
    cases: Annotated[list[Path], typer.Argument(help=CASES)],
    out: Annotated[Path, typer.Option(help="folder for what was said of each case; goes on where it was")],
) -> None:
    """Diagnose with a part of the method left out, one part after the other."""
    typer.echo(ablation(cases, out, lambda line: typer.echo(line, err=True)))


@app.command("placebo")
def mixed_up(
    cases: Annotated[list[Path], typer.Argument(help=CASES)],
    out: Annotated[Path, typer.Option(help="folder for what was gained in each case; goes on where it was")],
    seed: Annotated[int, typer.Option(help="of what is mixed up")] = 0,
) -> None:
    """Screen fingerprints with time, places or directions mixed up beside the true ones."""
    typer.echo(placebos(cases, out, lambda line: typer.echo(line, err=True), seed))


if __name__ == "__main__":
    app()
