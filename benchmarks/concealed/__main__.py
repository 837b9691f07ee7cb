"""`python -m benchmarks.concealed make|many|list`: bundles with something concealed, and the answers in files of their own."""

from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
import yaml

from benchmarks.concealed.case import STRENGTHS, Case
from benchmarks.concealed.effects.library import LIBRARY
from benchmarks.concealed.make import make as make_case

app = typer.Typer(add_completion=False, no_args_is_help=True, help=__doc__)


@app.command()
def make(
    effect: Annotated[list[str], typer.Option(help="name from `list`, or none; repeat it for a pair")],
    bundle: Annotated[Path, typer.Option(help="folder of the bundle")],
    answers: Annotated[Path, typer.Option(help="JSON file of the answers; arrays go to .npz beside it")],
    strength: Annotated[str, typer.Option(help=", ".join(STRENGTHS))] = "medium",
    seed: int = 0,
    held_out: Annotated[
        Path | None, typer.Option(help="folder of a bundle for prediction, of two more motions")
    ] = None,
    motion: Annotated[
        list[str] | None, typer.Option(help="to film, in this order, in place of drawn ones; repeat it")
    ] = None,
) -> None:
    """Film one case."""
    found = make_case(replace(_case(effect, strength, seed), motions=tuple(motion or ())), bundle, answers, held_out)
    typer.echo(_line(found))


@app.command()
def many(
    cases: Annotated[Path, typer.Option(help="YAML list of {effects: [..], strength: medium, seed: 1}")],
    out: Annotated[Path, typer.Option(help="each case gets OUT/EFFECTS_STRENGTH_SEED/{bundle,heldout,answers.json}")],
    parallel: Annotated[int, typer.Option(help="processes")] = 1,
    held_out: bool = True,
) -> None:
    """Film several cases; those that are there already stay. A case that fails is told and does not stop the others."""
    todo = [
        case
        for case in (
            _case(c["effects"], c.get("strength", "medium"), c["seed"]) for c in yaml.safe_load(cases.read_text())
        )
        if not (out / case.folder / "answers.json").exists()
    ]
    failed = 0
    with ProcessPoolExecutor(parallel) as pool:
        films = {pool.submit(_film, case, out, held_out): case for case in todo}
        for film in as_completed(films):
            error = film.exception()
            failed += error is not None
            typer.echo(f"{films[film].folder}: {film.result() if error is None else f'FAILED: {error}'}")
    if failed:
        raise typer.Exit(1)


@app.command("list")
def list_effects() -> None:
    """Print the effects: name, whether the format has a name for it, what is computed."""
    for name, recipe in LIBRARY.items():
        typer.echo(f"{name:28s} {'table' if recipe.in_table else 'outside'}  shown by {', '.join(recipe.shown_by)}")


def _film(case: Case, out: Path, held_out: bool) -> str:
    place = out / case.folder
    return _line(make_case(case, place / "bundle", place / "answers.json", place / "heldout" if held_out else None))


def _case(effects: list[str], strength: str, seed: int) -> Case:
    return Case(tuple(name for name in effects if name != "none"), strength, seed)


def _line(found: dict) -> str:
    effects = ", ".join(
        f"{effect['name']} ({', '.join(f'{key} {value:.4g}' for key, value in effect['parameters'].items())})"
        for effect in found["effects"]
    )
    change, noise = found["effect_rms_m"], found["noise_rms_m"]
    return (
        f"{effects or 'none'}: largest change {change['largest'] * 1e3:.2f} mm, total {change['total'] * 1e3:.2f} mm, "
        f"noise {noise * 1e3:.2f} mm, {found['made_in_s']:.0f} s"
    )


if __name__ == "__main__":
    app()
