"""`sim1 recordings`: a lab's recordings, brought into a bundle and examined."""

import json
from pathlib import Path
from typing import Annotated

import typer

from assets_defs._open import stop

recordings = typer.Typer(help="Recordings of real cloth: bring them in, see what they can tell.", no_args_is_help=True)


@recordings.command()
def check(
    bundle: Annotated[Path, typer.Argument(help="Folder with bundle.yaml.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """What is wrong with a bundle, and which effects its recordings can and cannot tell apart. Ends with 1 if unusable."""
    from sim1.recording.examination import examine

    examination = examine(bundle)
    if as_json:
        print(json.dumps(examination.as_json(), indent=1, allow_nan=False))
    else:
        _print_examination(examination)
    raise typer.Exit(0 if examination.usable else 1)


def _print_examination(examination) -> None:
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    console = Console()

    def line(mark: str, text: str, remedy: str = "") -> None:
        after = f" [dim]-> {escape(remedy)}[/]" if remedy else ""
        console.print(f"{mark} {escape(text)}{after}", highlight=False, soft_wrap=True)

    for problem in examination.problems:
        line("[red]wrong [/]", problem)
    for first in range(0, len(examination.recordings), _SIDE_BY_SIDE):
        some = examination.recordings[first : first + _SIDE_BY_SIDE]
        table = Table(title=escape(str(examination.bundle)))
        table.add_column("", no_wrap=True)
        for figures in some:
            table.add_column(escape(figures.name), overflow="fold")
        for name, show in _ROWS:
            table.add_row(name, *(show(figures) for figures in some))
        console.print(table)
    for said in examination.statements:
        line("[green]can   [/]" if said.can else "[yellow]cannot[/]", said.text, said.record)
    for text in examination.wanting:
        line("[red]wants [/]", text)
    if examination.usable:
        line("[green]usable[/]", "for a diagnosis")


def _span(values: tuple[float, float] | None) -> str:
    return "?" if values is None else f"{values[0]:.2g} .. {values[1]:.2g}"


def _noise(figures) -> str:
    noise = figures.noise
    if noise is None:
        return "?"
    return f"{1e3 * noise.std_m:.2g} (core {1e3 * noise.core_std_m:.2g}){'' if noise.at_rest else ' at most'}"


def _correlation(figures) -> str:
    noise = figures.noise
    if noise is None or noise.correlation_s is None:
        return "?"
    return f"{noise.correlation_s:.2g} ({noise.slow_share:.0%} of it)" if noise.slow_share else "within a frame"


_SIDE_BY_SIDE = 3  # recordings in one table
_ROWS = (
    ("duration, s", lambda f: f"{f.duration_s:.3g}"),
    ("rate of markers, drives, Hz", lambda f: f"{f.marker_rate_hz:.3g}, {f.drive_rate_hz:.3g}"),
    ("seen, %", lambda f: f"{100 * f.seen_share:.0f}"),
    ("seen least: marker; %", lambda f: f"{f.worst_marker}; {100 * f.worst_seen_share:.0f}"),
    ("longest occlusion, s", lambda f: f"{f.longest_occlusion_s:.2g}"),
    ("rest before, after, s", lambda f: f"{f.rest_s:.2g}, {f.rest_at_end_s:.2g}"),
    ("noise per coordinate, mm", _noise),
    ("its correlation time, s", _correlation),
    ("speed, m/s", lambda f: _span(f.speed_m_s)),
    ("across the cloth, m/s", lambda f: _span(f.normal_m_s)),
    ("along the cloth, m/s", lambda f: _span(f.tangential_m_s)),
    ("drive: travel, m; turn, rad", lambda f: f"{f.drive_travel_m:.2g}; {f.drive_turn_rad:.2g}"),
    ("on the table, s", lambda f: "no table" if f.touches_table_s is None else f"{f.touches_table_s:.2g}"),
    ("holds: all, changed, places known", lambda f: f"{f.hold_count}, {f.changed_holds}, {f.measured_holds}"),
    ("free decay, s", lambda f: f"{f.free_decay_s:.2g}"),
)


@recordings.command("import")
def bring(
    kind: Annotated[str, typer.Argument(help="motive, nexus, csv, c3d, npz (markers) or lerobot (joints).")],
    files: Annotated[
        list[Path], typer.Argument(help="A file for each recording, named like it; or the dataset folder.")
    ],
    out: Annotated[Path, typer.Option("--out", help="Bundle to write.")],
    with_file: Annotated[
        Path | None, typer.Option("--with", help="What the files cannot know. Default: import.yaml beside them.")
    ] = None,
    units: Annotated[
        str | None, typer.Option(help="Unit of length, where the files do not say: m, cm, mm, in.")
    ] = None,
    up: Annotated[str | None, typer.Option(help="Axis that points up in the files: y or z.")] = None,
    robot: Annotated[Path | None, typer.Option(help="Folder of the robot, for joints. Default: data/robot.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a bundle that is there.")] = False,
) -> None:
    """Bring the files of a motion-capture lab into a bundle; docs/recordings.md."""
    from pipeline import Home
    from sim1.recording.importing.write import import_bundle
    from sim1.recording.problems import Several
    from sim1.stage import BadInput

    if up not in (None, "y", "z"):
        stop(f"--up {up}: expected y or z")
    try:
        done = import_bundle(
            kind,
            files,
            out,
            import_file=with_file,
            units=units,
            up=up,
            robot=robot or Home.here().root / "data" / "robot",
            force=force,
        )
    except Several as error:
        stop("\n".join(error.messages))
    except BadInput as error:
        stop(str(error))
    for recording in done.bundle.recordings:
        seen = 100 * recording.seen.mean()
        typer.echo(f"{recording.name}: {len(recording.time_s)} frames, {seen:.0f} % of samples seen")
    if done.left_out:
        typer.echo(f"left out, not on the cloth: {', '.join(done.left_out[:20])}")
    typer.echo(f"wrote {out}; next: sim1 recordings check {out}")
