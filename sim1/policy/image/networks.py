"""The networks of an image policy, which differ in their seed: each is trained and tried by one process, several at once.

states/NNNN/       where a training is, see `sim1.policy.image.checkpoint`
episodes/NNNN/     what became of it: policy/, losses.parquet, errors.parquet; with attempts/ and work/ of `sim1.crew`
"""

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from lerobot.configs import PreTrainedConfig

from sim1.crew import finished, labour_together
from sim1.policy.counting import read_table
from sim1.policy.image.build import load, save
from sim1.policy.image.evaluation import ERROR_COLUMNS
from sim1.policy.image.exam import Exam
from sim1.policy.image.frames import Statistics
from sim1.policy.image.training import TrainingPlan, train
from sim1.progress import overheard, report, within
from sim1.quota import Quota, Row, Ticket
from sim1.stage import BadInput
from sim1.whole_file import whole_file

POLICY, LOSSES, ERRORS = "policy", "losses.parquet", "errors.parquet"
TRAINED = 0.85  # share of a network's progress that is reached when it is trained


@dataclass(frozen=True, kw_only=True)
class Course:
    """What all networks share, but for the seed of the plan."""

    dataset: Path
    episodes: Sequence[int]  # of the training part
    settings: PreTrainedConfig
    weights: Path | None
    fresh: Sequence[str]
    statistics: Statistics
    plan: TrainingPlan
    seeds: Sequence[int]  # of the networks
    exam: Exam


@dataclass(frozen=True, kw_only=True)
class Teacher:
    """Makes networks (`sim1.crew.Maker`)."""

    course: Course
    root: Path

    def make(self, ticket: Ticket, folder: Path) -> Row:
        """Train and try the network of that place among the seeds."""
        place, course = ticket.number, self.course
        seed, state = course.seeds[place], self.root / "states" / ticket.name
        begin, end = (at / len(course.seeds) for at in (place, place + 1))
        with within(begin, end), overheard(functools.partial(_note, state.with_suffix(".share"))):
            with within(0.0, TRAINED):
                trained, losses = train(
                    course.dataset,
                    course.episodes,
                    course.settings,
                    course.weights,
                    course.fresh,
                    course.statistics,
                    replace(course.plan, seed=seed),
                    state,
                )
            if not all(item.isfinite().all() for item in trained.policy.parameters()):
                raise BadInput(
                    f"stage image_policy: weights of the network of seed {seed} are not finite after {course.plan.steps} steps; "
                    "set a smaller learning rate among the settings of its policy file"
                )
            save(folder / POLICY, trained)
            steps = np.arange(1, len(losses) + 1)
            pd.DataFrame({"seed": seed, "step": steps, "loss": losses}).to_parquet(folder / LOSSES, index=False)
            with within(TRAINED, 1.0):
                rows = course.exam.errors(load(folder / POLICY, course.settings.device))
            table = pd.DataFrame(rows, columns=list(ERROR_COLUMNS))
            table.insert(0, "seed", np.full(len(table), seed))
            table.to_parquet(folder / ERRORS, index=False)
        return {"ran": True, "seed": seed}


def make_networks(course: Course, root: Path, processes: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Losses (`seed`, `step`, `loss`) and errors (`seed`, then `ERROR_COLUMNS`) of all networks; `root` keeps what is made.

    Raises:
        BadInput: published weights do not fit, or what is kept of an interrupted training is damaged.
        CrewDied: processes died; what is made stays.
    """
    count = len(course.seeds)
    tickets = [Ticket(series="", number=place) for place in range(count)]

    def tell(rows: dict[str, Row]) -> None:
        shares = [1.0 if one.name in rows else _noted(root / "states" / f"{one.name}.share") for one in tickets]
        report(sum(shares), count, f"{len(rows)} of {count} networks")

    root.mkdir(exist_ok=True)
    (root / "states").mkdir(exist_ok=True)
    alone = processes == 1  # then the network that is trained tells of itself
    teacher = functools.partial(Teacher, course=course, root=root)
    labour_together(root, [Quota.of("", count)], teacher, processes, (lambda rows: None) if alone else tell)
    finished(root)
    report(1.0, 1.0, "networks trained and tried")
    losses, errors = (
        pd.concat([read_table(root / "episodes" / one.name / name) for one in tickets], ignore_index=True)
        for name in (LOSSES, ERRORS)
    )
    return losses, errors


def take_policies(root: Path, seeds: Sequence[int], out: Path) -> None:
    """Move the policies of all networks from `root` to `out`, a folder by the seed of each: there whole, or not at all."""
    part = out.with_name(f"{out.name}.part")
    part.mkdir(exist_ok=True)
    for place, seed in enumerate(seeds):
        made = root / "episodes" / Ticket(series="", number=place).name / POLICY
        if made.exists():  # else a killed run has moved it
            made.rename(part / str(seed))
    part.rename(out)


def _note(path: Path, done: float, total: float, what: str) -> None:
    """For the process that started this one."""
    with whole_file(path) as part:
        part.write_text(str(done / total if total else 0.0))


def _noted(path: Path) -> float:
    try:
        return float(path.read_text())
    except FileNotFoundError:  # nobody has begun
        return 0.0
