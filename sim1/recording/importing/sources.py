"""Which file each recording of an import comes from."""

from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from sim1.recording.importing.import_file import ImportFile, MarkerKind
from sim1.stage import BadInput

KINDS = (*get_args(MarkerKind.__value__), "lerobot")


@dataclass(frozen=True, kw_only=True)
class Sources:
    """Where the recordings of one import come from."""

    import_file: Path
    document: ImportFile
    markers: dict[str, tuple[str, Path]]  # recording -> kind and file
    dataset: Path | None  # LeRobot dataset of the command line
    robot: Path | None  # folder of the robot that recorded it
    units: str | None  # of the command line
    up: str | None


def pair_files(
    kind: str, files: list[Path], import_file: Path, document: ImportFile
) -> tuple[dict[str, tuple[str, Path]], Path | None]:
    """Marker file of each recording, and the dataset where one was given.

    Raises:
        BadInput: a recording without a file or with two, a file without a recording, an unknown kind.
    """
    if kind not in KINDS:
        raise BadInput(f"kind {kind!r} is unknown; expected one of {', '.join(KINDS)}")
    if kind == "lerobot" and len(files) != 1:
        raise BadInput(f"kind lerobot takes one dataset folder, got {len(files)}")
    given = {} if kind == "lerobot" else {path.stem: path for path in files}
    if len(given) < len(files) and kind != "lerobot":
        raise BadInput(
            f"{files[0].parent}: two of the files have one name less ending; a recording is named after its file"
        )
    if strange := sorted(set(given) - set(document.recordings)):
        raise BadInput(
            f"{import_file}: recordings has {sorted(document.recordings)}, and {given[strange[0]]} is none of them; "
            "name each recording after its file, less the ending"
        )
    paired = {}
    for name, part in document.recordings.items():
        if (name in given) == (part.markers is not None):
            raise BadInput(
                f"{import_file}: recordings.{name}: its markers are given {'twice' if name in given else 'nowhere'}; "
                f"give a file {name}.* on the command line, or markers: {{kind, file}} here"
            )
        paired[name] = (
            (kind, given[name]) if name in given else (part.markers.kind, import_file.parent / part.markers.file)
        )
    return paired, files[0] if kind == "lerobot" else None
