"""`import.yaml`: what the files of a motion-capture system cannot know, checked strictly."""

from pathlib import Path
from typing import Annotated, Literal

import pydantic

from sim1.recording.document import Environment, Name, Priors, Vector, wrong_environment, wrong_priors
from sim1.recording.problems import Several
from sim1.recording.strict_yaml import Strict, read_strict
from sim1.stage import BadInput

SCHEMA = "sim1.import/1"

type MarkerKind = Literal["motive", "nexus", "csv", "c3d", "npz"]
type Unit = Literal["m", "cm", "mm", "in"]
type File = Annotated[str, pydantic.Field(pattern=r"^[^\x00-\x1f]+$")]  # path from the folder of import.yaml
type Shift = Annotated[float, pydantic.Field(ge=-100, le=100)]  # metres
type Part = Annotated[float, pydantic.Field(ge=-1.001, le=1.001)]  # of a unit quaternion


class GarmentSource(Strict):
    """Rest mesh and priors."""

    mesh: File
    units: Unit = "m"  # of the mesh file, `v` and `vt`
    prior: Priors


class Frame(Strict):
    """Where the frame of the cameras (after z was turned up) stands in the robot's."""

    shift_m: tuple[Shift, Shift, Shift] = (0.0, 0.0, 0.0)
    rotation_wxyz: tuple[Part, Part, Part, Part] = (1.0, 0.0, 0.0, 0.0)


class MarkersSource(Strict):
    """What holds for the markers of all recordings."""

    labels: (
        dict[str, pydantic.NonNegativeInt] | Literal["numbers"]
    )  # label in the files -> id; "numbers": the label is the id
    noise_std_m: pydantic.PositiveFloat | None = None
    units: Unit | None = None  # null: as the files say
    up: Literal["y", "z"] | None = None  # null: y for motive, z for the others
    to_world: Frame = Frame()


class Anchor(Strict):
    """Where one marker sits on the mesh."""

    marker: str  # label
    face: pydantic.NonNegativeInt
    weights: Vector


class MarkerFile(Strict):
    """Marker file of one recording, where it is not given on the command line."""

    kind: MarkerKind
    file: File


class DriveFile(Strict):
    """Drives of one recording: a table, an archive, or an episode of a LeRobot dataset."""

    kind: Literal["csv", "npz", "lerobot"]
    file: File | None = None  # null: from the command line (lerobot), or the archive of the markers (npz)
    episode: pydantic.NonNegativeInt | None = None  # of a dataset
    use: Literal["action", "observation.state"] = "action"  # of a dataset: what was commanded, or measured
    shift_s: float = 0.0  # added to the drives' time stamps; then they count on the markers' clock


class HoldSource(Strict):
    """A hold; from and to are the whole recording where they are not given."""

    drive: str
    vertices: Annotated[list[pydantic.NonNegativeInt], pydantic.Field(min_length=1)]
    from_s: float | None = None
    to_s: float | None = None
    places_m: list[Vector] | None = None


class RecordingSource(Strict):
    """One recording."""

    starts: Literal["rest", "moving"]
    holds: list[HoldSource]
    drives: DriveFile
    markers: MarkerFile | None = (
        None  # null: the file on the command line whose name, less its ending, is the recording's
    )
    cut_s: tuple[float, float] | None = None  # keep this part alone, on the markers' clock


class ImportFile(Strict):
    """Contents of `import.yaml`."""

    schema_: Literal["sim1.import/1"] = pydantic.Field(alias="schema")
    garment: GarmentSource
    environment: Environment
    markers: MarkersSource
    anchors: File | list[Anchor]  # a CSV file, or each anchor
    recordings: Annotated[dict[Name, RecordingSource], pydantic.Field(min_length=1)]


def read_import_file(path: Path) -> ImportFile:
    """Read and check an `import.yaml`.

    Raises:
        BadInput: missing, not YAML, an unknown, missing or repeated key, a value out of range, two labels with one id.
    """
    document = read_strict(path, ImportFile, f"import.yaml, schema {SCHEMA} (docs/recordings.md)")
    wrong = [*wrong_priors(path, document.garment.prior), *wrong_environment(path, document.environment)]
    labels = document.markers.labels
    if isinstance(labels, dict):
        if not labels:
            wrong.append(f"{path}: markers.labels is empty; name the markers on the cloth, or say numbers")
        for label in labels:
            if twice := [other for other in labels if other < label and labels[other] == labels[label]]:
                wrong.append(f"{path}: markers.labels: {twice[0]!r} and {label!r} have one id, {labels[label]}")
    if document.anchors == "nearest":
        wrong.append(
            f"{path}: anchors: nearest is not enough: a hanging cloth curves, and its mirror image fits as well; "
            "give a CSV file with marker, u_m, v_m (measured with a ruler along warp and weft)"
        )
    length = sum(value**2 for value in document.markers.to_world.rotation_wxyz) ** 0.5
    if abs(length - 1) > 1e-3:
        wrong.append(f"{path}: markers.to_world.rotation_wxyz has length {length:.4g}; expected 1 (w first)")
    for name, recording in document.recordings.items():
        drives = recording.drives
        if drives.kind == "lerobot" and drives.episode is None:
            wrong.append(f"{path}: recordings.{name}.drives.episode is missing; give the episode's index")
        if drives.kind == "csv" and drives.file is None:
            wrong.append(f"{path}: recordings.{name}.drives.file is missing; name the table of the drives")
        if recording.cut_s is not None and recording.cut_s[1] <= recording.cut_s[0]:
            wrong.append(f"{path}: recordings.{name}.cut_s is {list(recording.cut_s)}; expected [from, to]")
    if wrong:
        raise Several(wrong)
    return document


def default_import_file(first: Path) -> Path:
    """`import.yaml` beside the first file or folder of a command.

    Raises:
        BadInput: there is none.
    """
    path = first.parent / "import.yaml"
    if not path.is_file():
        raise BadInput(
            f"{path}: missing; it says what {first.name} cannot: mesh, priors, labels, anchors, holds (--with PATH)"
        )
    return path
