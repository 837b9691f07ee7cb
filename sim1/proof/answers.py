"""A laboratory's answers, as far as they are read: what was concealed, and the courses that findings are set against."""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
import pydantic

from sim1.array_file import Shape, numbers_of, read_arrays
from sim1.cloth.effects import EFFECTS
from sim1.data_file import explained
from sim1.proof.draw import Case
from sim1.stage import BadInput

WHAT, REMEDY = "answer", "film the case again"
COURSE = ("/stamps_s", "/missing_n_m2")  # arrays of each recording
TRUTH = ("/truth_s", "/truth_m")  # arrays of each motion that no diagnosis is given


class _Effect(pydantic.BaseModel, allow_inf_nan=False):
    name: str
    parameters: dict[str, float]
    extras: dict[str, float] = {}  # true values that the format's table has no name for, as a wind's drag
    named_by_format: bool
    own_rms_m: float | None = (
        None  # by which it moves markers, less what nothing else could have; None: a laboratory that does not say
    )


class Answers(pydantic.BaseModel, allow_inf_nan=False):
    """What is read of a laboratory's answers; they hold more."""

    case: Case
    effects: list[_Effect]
    baseline: dict[str, float]
    places_given: bool
    target_rms_m: float = 0.0  # as strong as it was to come out

    @property
    def reached(self) -> dict[str, float]:
        """How strong each effect came out, in units of what was asked for; of those of which the laboratory says it."""
        told = {effect.name: effect.own_rms_m for effect in self.effects}
        return {
            name: own / self.target_rms_m for name, own in told.items() if own is not None and self.target_rms_m > 0.0
        }


def read_answers(path: Path, asked: Case | None = None) -> Answers:
    """Read the answers and see that they are those of the drawn case, where one is given.

    Raises:
        BadInput: missing, damaged, with a value that no effect can have, or answers to another question.
    """
    try:
        answers = Answers.model_validate(json.loads(path.read_bytes()))
    except (OSError, ValueError) as error:
        said = explained(error) if isinstance(error, pydantic.ValidationError) else str(error)
        raise BadInput(f"{path}: not readable as answers ({said}); {REMEDY}") from error
    for effect in answers.effects:
        lowest = (
            {name: low for name, (low, _) in EFFECTS[effect.name].allowed().items()} if effect.name in EFFECTS else {}
        )
        if bad := [name for name, value in effect.parameters.items() if value <= 0.0 < lowest.get(name, 0.0)]:
            raise BadInput(
                f"{path}: {effect.name}: {bad[0]} is {effect.parameters[bad[0]]:g}, must be above 0; {REMEDY}"
            )
    if asked and _of(answers.case) != _of(asked):
        raise BadInput(f"{path}: answers for {_of(answers.case)}, drawn were {_of(asked)}; {REMEDY}")
    return answers


def _of(case: Case) -> str:
    """A question in words; how strong nothing is means nothing."""
    strength = f", {case.strength}" if case.effects else ""
    return f"{sorted(case.effects)}{strength} with seed {case.seed}"


def read_courses(path: Path, recordings: Iterable[str] = ()) -> dict[str, np.ndarray]:
    """Courses in the answers, all finite:

    `NAME/stamps_s` (F,) and `NAME/missing_n_m2` (F, M) of every one of `recordings`, and of all others that the answers tell of;
    `NAME/truth_s` (T,) and `NAME/truth_m` (T, M, 3) of the motions that no diagnosis was given.

    Raises:
        BadInput: the file is damaged, or an array is missing, of another shape or not finite.
    """
    arrays = read_arrays(path, (), WHAT, REMEDY)
    filmed, unseen = ({key.rpartition("/")[0] for key in arrays if key.endswith(ends)} for ends in (COURSE, TRUTH))
    if not (known := sorted(filmed | set(recordings))):
        raise BadInput(f"{path}: not a readable {WHAT} (no array 'NAME/stamps_s' of any recording); {REMEDY}")
    shapes: dict[str, Shape] = {}
    for name in known:
        shapes |= {f"{name}/stamps_s": (f"F of {name}",), f"{name}/missing_n_m2": (f"F of {name}", "M")}
    for name in sorted(unseen):
        shapes |= {f"{name}/truth_s": (f"T of {name}",), f"{name}/truth_m": (f"T of {name}", "markers", 3)}
    return numbers_of(arrays, path, shapes, WHAT, REMEDY)


def kind_of(answers: Answers) -> Literal["null", "outside", "several", "single"]:
    """What sort of question it was; one effect outside the table makes it `outside`."""
    return kind_from([effect.named_by_format for effect in answers.effects])


def kind_from(in_table: Sequence[bool]) -> Literal["null", "outside", "several", "single"]:
    """The same from whether each concealed effect is one of the table."""
    if not in_table:
        return "null"
    if not all(in_table):
        return "outside"
    return "single" if len(in_table) == 1 else "several"
