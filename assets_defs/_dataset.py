"""`sim1 dataset`: any LeRobot v3 dataset checked, merged, split, and one made of generated episodes."""

from pathlib import Path
from typing import Annotated

import typer

from assets_defs._open import open_home, stop

dataset = typer.Typer(
    help="LeRobot v3 datasets, this project's or others: check, merge, split; make one of generated episodes.",
    no_args_is_help=True,
)
PHYSICS = ("garment_mesh", "scene", "calibrated_physics")  # that episodes show, and that their provenance names

Folder = Annotated[Path, typer.Argument(help="LeRobot root, or an artifact such as data/store/dataset/_.")]
Out = Annotated[Path, typer.Option(help="New folder.")]


@dataset.command()
def check(
    folder: Folder,
    episodes: Annotated[
        list[Path] | None,
        typer.Option(
            help="Folder of the simulation's episodes that it was made from (data/store/rendered_episodes), to compare every frame "
            "with; may be given more than once. In a store they are found."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Say what is wrong with a dataset; ends with 1 where something is."""
    import json

    from sim1.dataset.beside import PROVENANCE
    from sim1.dataset.check import check_lerobot
    from sim1.dataset.check_provenance import check_provenance
    from sim1.dataset.check_source import check_source, sources_beside
    from sim1.dataset.limits import FILE, read_limits
    from sim1.dataset.reshape import lerobot_root
    from sim1.stage import BadInput

    try:
        root = lerobot_root(folder)
        limits = read_limits(folder) if (folder / FILE).is_file() else None
    except BadInput as error:
        stop(str(error))
    if missing := [path for path in episodes or () if not path.is_dir()]:
        stop(
            f"--episodes {missing[0]}: no such folder; give the one with episodes/ in it, or with a folder per garment"
        )
    known = root != folder and (folder / PROVENANCE).is_file()
    if episodes and not known:
        stop(
            f"--episodes: {folder} has no {PROVENANCE} that names them; give an artifact of stage dataset, not its lerobot/"
        )
    findings = check_lerobot(root, limits=limits)
    if known and findings[0].passed:
        findings += check_provenance(folder)
        if near := episodes or sources_beside(folder):
            findings.append(check_source(folder, near, all_there=bool(episodes)))
    if as_json:
        print(json.dumps([vars(finding) for finding in findings], indent=1, default=bool))
    else:
        for finding in findings:
            print(f"{'ok    ' if finding.passed else 'FAILED'} {finding.name}: {finding.detail}")
    if not all(finding.passed for finding in findings):
        raise typer.Exit(1)


@dataset.command()
def merge(
    folders: Annotated[list[Path], typer.Argument(help="Two or more datasets.")],
    out: Out,
) -> None:
    """One dataset of several with the same features and rate; with provenance, keypoints and limits where all have them."""
    from sim1.dataset import reshape
    from sim1.dataset.beside import lacking
    from sim1.stage import BadInput

    if len(folders) < 2:
        stop(f"give two datasets or more, got {len(folders)}")
    try:
        count = reshape.merge(folders, out)
    except BadInput as error:
        stop(str(error))
    for folder in folders:
        if lacks := lacking(folder):
            print(f"{folder}: no {', '.join(lacks)}: what one dataset lacks, the whole lacks")
    print(f"{count} episodes in {out / 'lerobot'}")


@dataset.command()
def split(
    folder: Folder,
    out: Out,
    share: Annotated[list[str], typer.Option(help="PART=SHARE, once for each part; shares add up to 1.")],
    seed: Annotated[int, typer.Option(min=0)] = 0,
) -> None:
    """Parts of a dataset; episodes that were made from a common demonstration stay together."""
    from sim1.dataset import reshape
    from sim1.dataset.beside import PROVENANCE, lacking
    from sim1.stage import BadInput

    try:
        shares = {name: float(value) for name, _, value in (item.partition("=") for item in share)}
    except ValueError:
        stop(f"--share {' '.join(share)}: expected PART=SHARE such as train=0.8")
    if len(shares) < len(share) or not all(name.isidentifier() for name in shares):
        stop(f"--share {' '.join(share)}: every part needs a name of its own, of letters, digits and _")
    try:
        counts = reshape.split(folder, shares, out, seed)
    except BadInput as error:
        stop(str(error))
    if PROVENANCE in lacking(folder):
        print(f"{folder}: no provenance: every episode was split by itself, also from others of its demonstration")
    for name, count in counts.items():
        print(f"{count} episodes in {out / name / 'lerobot'}")


@dataset.command()
def make(
    folder: Annotated[Path, typer.Argument(help="Folder of `sim1 generate`.")],
    out: Annotated[Path, typer.Option(help="Folder for rendered/ and dataset/; one that was begun goes on.")],
) -> None:
    """Render the accepted episodes of `sim1 generate` and write a dataset of them, as the last full run's profile does it."""
    import dataclasses

    from assets_defs._config import config_of
    from assets_defs._origin import generated_origin, inputs_then, made_from, node_of
    from assets_defs._progress import bar
    from assets_defs._sources import source
    from assets_defs._store import StoreError, verified
    from sim1.dataset.generated import dataset_of_generated
    from sim1.progress import listening
    from sim1.render.blender import BlenderFailed
    from sim1.stage import BadInput

    given, asked = folder.resolve(), out.resolve()
    home, graph = open_home(None)
    try:
        origin = generated_origin(given)
        inputs, _ = inputs_then(home, graph, given, origin, PHYSICS)
        report, record = verified(home, node_of(graph, "mismatch_report", origin.variant), origin.garment)
        if made_from(record)["calibrated_physics"] != origin.versions["calibrated_physics"]:
            raise BadInput(f"{report}: is of another calibration; make it again: sim1 run --select mismatch_report")
        inputs["mismatch_report"] = {origin.garment: report}
        rendering, writing = (node_of(graph, name, origin.variant) for name in ("rendered_episodes", "dataset"))
        for node, name in ((rendering, "appearance"), (writing, "robot"), (writing, "owner")):
            if path := source(home, node, None, name):
                inputs[name] = {"": path}
        render = dataclasses.replace(config_of(rendering), max_episodes=0)
        with bar(1.0) as show, listening(lambda done, total, what: show(done / total if total else 0.0, what)):
            facts = dataset_of_generated(given, inputs, origin.garment, render, config_of(writing), asked)
    except (BadInput, StoreError, BlenderFailed) as error:
        stop(home.relative(str(error)))
    print(f"{facts['episodes']} episodes, {facts['frames']} frames in {asked / 'dataset' / 'lerobot'}")
