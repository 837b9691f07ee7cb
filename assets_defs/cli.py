"""The command line `sim1`. Imports what a command needs when it runs, so that `--help` answers at once."""

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from assets_defs._dataset import dataset
from assets_defs._diagnose import diagnose, predict
from assets_defs._generate import generate
from assets_defs._looks import looks
from assets_defs._open import open_home, stop
from assets_defs._prove import prove
from assets_defs._recordings import recordings
from assets_defs._replay import replay

app = typer.Typer(
    name="sim1",
    help="From a garment scan and a few demonstrations to a robot-learning dataset.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

app.add_typer(recordings, name="recordings")
app.add_typer(dataset, name="dataset")
app.command()(diagnose)
app.command()(predict)
app.command()(prove)
app.command()(generate)
app.command()(looks)
app.command()(replay)

Profile = Annotated[
    str | None, typer.Option(help="Sizes: smoke, quick, study or paper. Default: that of the last run of everything.")
]
Garments = Annotated[list[str] | None, typer.Option("--garment", help="Only this garment (may be repeated).")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]


@app.command()
def run(
    profile: Profile = None,
    garment: Garments = None,
    select: Annotated[list[str] | None, typer.Option(help="Only this stage and what it needs (repeatable).")] = None,
    variant: Annotated[str | None, typer.Option(help="Only this ablation variant, or 'base' for none.")] = None,
    jobs: Annotated[int, typer.Option(help="Worker processes; 0 works in this process.")] = min(2, os.cpu_count() or 1),
) -> None:
    """Make everything that is not fresh. A killed run goes on where it was."""
    home, graph = open_home(profile)
    from assets_defs._run import run_with_progress, selected
    from assets_defs._sources import faults

    try:
        nodes = selected(graph, select, variant)
        if unknown := set(garment or []) - set(home.garments()):
            stop(
                f"--garment {sorted(unknown)[0]}: there is no data/garments/{sorted(unknown)[0]}.yaml; there are {home.garments()}"
            )
    except ValueError as error:
        stop(str(error))
    if found := faults(home, graph, nodes, garment):
        stop(
            "nothing was made; mend these files first (or name the garments to make with --garment)\n  "
            + "\n  ".join(found)
        )
    raise typer.Exit(run_with_progress(home, graph, nodes, garment, jobs))


@app.command()
def status(profile: Profile = None, as_json: AsJson = False) -> None:
    """Stage x garment: fresh, stale and why, missing."""
    home, graph = open_home(profile)
    from assets_defs._status import print_status

    print_status(home, graph, as_json=as_json)


@app.command()
def audit(
    asset: Annotated[
        str, typer.Argument(help="STAGE or STAGE/GARMENT; of a variant VARIANT/STAGE or VARIANT/STAGE/GARMENT.")
    ],
    against: Annotated[str | None, typer.Option(help="Variant to compare with.")] = None,
    as_json: AsJson = False,
) -> None:
    """What made an artifact: every ancestor with version, config, seed and data version."""
    home, graph = open_home(None)
    from assets_defs._audit import print_audit

    try:
        print_audit(home, graph, asset, against, as_json=as_json)
    except LookupError as error:
        stop(str(error.args[0]))


@app.command()
def clean(
    everything: Annotated[bool, typer.Option("--all", help="All artifacts and the event log too.")] = False,
    garment: Garments = None,
    select: Annotated[list[str] | None, typer.Option(help="Only this stage's artifacts (repeatable).")] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask.")] = False,
) -> None:
    """Remove leftovers, and artifacts of garments and variants that are no more (asks first); with options, others."""
    home, graph = open_home(None)
    from assets_defs._clean import clean as remove
    from assets_defs._clean import doomed
    from assets_defs._store import StoreError, alone

    try:
        with alone(home):
            paths, held = doomed(home, graph, everything=everything, garments=garment, stages=select)
            for line in held:
                typer.echo(f"left alone: {home.relative(line)}")
            if not paths:
                typer.echo("nothing to remove")
                return
            for path in paths[:20]:
                typer.echo(f"  {path.relative_to(home.root)}")
            if len(paths) > 20:
                typer.echo(f"  and {len(paths) - 20} more")
            if not yes and not typer.confirm(f"Remove these {len(paths)}?"):
                raise typer.Exit(1)
            typer.echo(f"removed {remove(home, paths) / 2**20:.1f} MiB")
    except (StoreError, ValueError) as error:
        stop(home.relative(str(error)))


@app.command()
def doctor(as_json: AsJson = False) -> None:
    """What works on this machine, what is missing, and how to get it."""
    from assets_defs._doctor import print_doctor
    from pipeline import Home

    raise typer.Exit(print_doctor(Home.here(), as_json=as_json))


@app.command()
def ui(
    port: Annotated[int, typer.Option(help="Port of the web page.")] = 3000,
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    profile: Profile = None,
) -> None:
    """Dagster's web page for this project, with the daemon that runs schedule and automation."""
    home, _ = open_home(profile)
    from pipeline.home import REPOSITORY

    binary = Path(sys.executable).with_name("dagster")
    own = home.root / "workspace.yaml"
    workspace = own if own.is_file() else REPOSITORY / "workspace.yaml"
    os.execv(binary, [str(binary), "dev", "-h", host, "-p", str(port), "-w", str(workspace)])


def main() -> None:
    """Entry point."""
    app()


if __name__ == "__main__":
    main()
