"""An imported bundle on disk: whole and checked, or not at all."""

import os
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

from sim1.mismatch.destination import writable_folder
from sim1.recording.bundle import Bundle, read_bundle, write_bundle
from sim1.recording.importing.assemble import Assembled, assemble
from sim1.recording.importing.import_file import default_import_file, read_import_file
from sim1.recording.importing.sources import Sources, pair_files
from sim1.stage import BadInput


@dataclass(frozen=True, kw_only=True)
class Imported:
    """What was brought in."""

    bundle: Bundle
    left_out: list[str]  # labels that are not on the cloth


def import_bundle(
    kind: str,
    files: list[Path],
    out: Path,
    *,
    import_file: Path | None = None,
    units: str | None = None,
    up: str | None = None,
    robot: Path | None = None,
    force: bool = False,
) -> Imported:
    """Read a lab's files of one kind and write the bundle `out`.

    Args:
        kind: "motive", "nexus", "csv", "c3d", "npz" (files of markers) or "lerobot" (a dataset folder with joints).
        files: one for each recording, named like it; or the dataset.
        out: folder to write; appears whole and checked, or not at all.
        import_file: `import.yaml`; None: beside the first file.
        units: unit of length of the files, where they do not say.
        up: axis that points up in the files; None: as import.yaml says, else as the kind has it.
        robot: folder of the robot, for joints.
        force: replace a bundle that is there.

    Raises:
        BadInput: a file is at fault, the result is no valid bundle, there is something at `out` already, or it cannot be written to.
    """
    out = out.absolute()
    _check_target(out, force)
    writable_folder(out.parent)
    if not files:
        raise BadInput("no files given; name the recordings' files, or the dataset folder")
    import_file = import_file or default_import_file(files[0])
    document = read_import_file(import_file)
    markers, dataset = pair_files(kind, files, import_file, document)
    sources = Sources(
        import_file=import_file, document=document, markers=markers, dataset=dataset, robot=robot, units=units, up=up
    )
    assembled = assemble(sources)
    return Imported(bundle=_put(out, assembled), left_out=assembled.left_out)


def _check_target(out: Path, force: bool) -> None:
    if not out.exists():
        return
    if not force:
        raise BadInput(f"{out}: is there already; give another --out, or --force to replace it")
    if not (out / "bundle.yaml").is_file():
        raise BadInput(f"{out}: is there and is not a bundle; --force replaces bundles alone")


def _put(out: Path, assembled: Assembled) -> Bundle:
    """Write a bundle beside `out`, read it back strictly, then move it into its place; gives what was read.

    Raises:
        BadInput: it does not read back, by the lab's files, or cannot be written; `out` is then as it was before.
    """
    part, old = (out.with_name(f".{out.name}.{word}-{os.getpid()}") for word in ("part", "old"))
    try:
        write_bundle(part, assembled.bundle)
        checked = replace(read_bundle(part, assembled.places), folder=out)
        if out.exists():
            out.rename(old)
        part.rename(out)
    except OSError as error:
        raise BadInput(
            f"{out}: cannot be written ({error.strerror or error}); free some space or give another place for --out"
        ) from error
    finally:
        shutil.rmtree(part, ignore_errors=True)
        if old.exists() and not out.exists():
            old.rename(out)
    shutil.rmtree(old, ignore_errors=True)
    return checked
