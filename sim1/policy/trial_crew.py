"""Trials by any number of processes, each with cells of its own; a killed run goes on with what is made."""

import functools
import json
import os
import shutil
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch

from sim1.crew import Maker, finished, labour_together
from sim1.film_strip import write_strip
from sim1.policy.lessons import ModelKey
from sim1.policy.model import ChunkPolicy, load_policy
from sim1.policy.trials import Bench, Trial, TrialSettings, open_bench, run_trial
from sim1.progress import report
from sim1.quota import Quota, Row, Ticket
from sim1.stage import BadInput, Facts, Inputs

STRIP = "strip.npz"
FACTS = "facts.json"  # of an experiment, beside its trials


@dataclass(frozen=True, kw_only=True)
class Plan:
    """All trials of an experiment."""

    inputs: Inputs
    models: Path  # folder of policy files
    drivers: Mapping[str, tuple[ModelKey, ...]]  # by garment
    keypoints: Mapping[str, np.ndarray]  # by garment
    settings: TrialSettings

    @property
    def trials(self) -> list[Trial]:
        """In the order of the table."""
        config = self.settings.config
        return [
            Trial(model=key, garment=garment, shift=shift, number=number)
            for garment, keys in self.drivers.items()
            for shift in config.shifts
            for key in keys
            for number in range(config.trial_count)
        ]


@dataclass(frozen=True, kw_only=True)
class Driver:
    """Makes trials (`sim1.crew.Maker`)."""

    plan: Plan
    _trials: Mapping[str, Trial]
    _benches: dict[tuple[str, float], Bench] = field(default_factory=dict)
    _models: dict[ModelKey, ChunkPolicy] = field(default_factory=dict)

    @classmethod
    def of(cls, plan: Plan) -> "Driver":
        """One thread a process: there are as many processes as are wanted."""
        torch.set_num_threads(1)
        return cls(plan=plan, _trials={trial.name: trial for trial in plan.trials})

    def make(self, ticket: Ticket, folder: Path) -> Row:
        """Drive; the row, and the film strip in `folder`."""
        trial, config = self._trials[ticket.name], self.plan.settings.config
        place = trial.garment, trial.friction_factor(config)
        if place not in self._benches:
            self._benches[place] = open_bench(self.plan.inputs, trial.garment, config.trials_in, place[1])
        if trial.model not in self._models:
            self._models[trial.model] = load_policy(self.plan.models / trial.model.file)
        model, keypoints = self._models[trial.model], self.plan.keypoints[trial.garment]
        row, strip = run_trial(self._benches[place], trial, model, keypoints, self.plan.settings)
        write_strip(folder / STRIP, strip)
        return {**row, "ran": True}


def run_trials(plan: Plan, root: Path, processes: int) -> tuple[list[dict[str, Any]], list[Path]]:
    """Rows and files of the film strips of all trials, in their order; `root` keeps what is made until they are.

    Raises:
        BadInput: an artifact is missing or damaged.
        CrewDied: processes died; what is made stays.
    """
    return make_trials(plan.trials, functools.partial(Driver.of, plan), root, processes)


def make_trials(
    trials: Sequence[Trial],
    prepare: Callable[[], Maker],
    root: Path,
    processes: int,
    foreseen: tuple[type[Exception], ...] = (BadInput,),
) -> tuple[list[dict[str, Any]], list[Path]]:
    """The same of trials whose rows and strips makers make, whoever drives; see `sim1.crew.labour_together`."""
    if not trials:
        return [], []
    root.mkdir(exist_ok=True)

    def count(rows: dict[str, Row]) -> None:
        report(len(rows), len(trials), f"{len(rows)} of {len(trials)} trials")

    labour_together(root, _quotas(trials), prepare, processes or os.process_cpu_count() or 1, count, foreseen)
    rows = {_name(row): {key: value for key, value in row.items() if key != "ran"} for row in finished(root)}
    return [rows[trial.name] for trial in trials], [root / "episodes" / trial.name / STRIP for trial in trials]


def finish(root: Path, facts: Facts) -> Facts:
    """Note what was found, once all is written that is made of trials, and remove what `make_trials` kept of them.

    The note, `facts.json` beside `root`, is there before anything is removed, and stays: a process may die until the
    artifact was checked and is in its place, and then needs no trial again.
    """
    note = root.with_name(FACTS)
    part = note.with_suffix(".part")
    part.write_text(json.dumps(facts, indent=1) + "\n")
    part.replace(note)
    return tidied(root)


def tidied(root: Path) -> Facts | None:
    """What a run noted that needs no trial any more, with what is left of its trials removed; None: there is none."""
    note = root.with_name(FACTS)
    if not note.exists():
        return None
    shutil.rmtree(root, ignore_errors=True)
    return json.loads(note.read_text())


def _quotas(trials: Sequence[Trial]) -> list[Quota]:
    """A series has all numbers from 0 on."""
    return [Quota.of(name, count) for name, count in Counter(trial.series for trial in trials).items()]


def _name(row: Row) -> str:
    key = ModelKey(trained_on=row["trained_on"], size=row["size"], seed=row["seed"])
    return Trial(model=key, garment=row["garment"], shift=row["shift"], number=row["trial"]).name
