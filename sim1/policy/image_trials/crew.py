"""Trials of image policies by any number of processes, each with a policy, cells and a live camera of its own."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from lerobot.utils.random_utils import seeded_context

from sim1.episode import RATE_HZ
from sim1.film_strip import FilmStrip, evenly, laid_down, write_strip
from sim1.policy.image.build import Trained, load
from sim1.policy.image_trials.looks import LOOK_COLUMNS, Dress, Wardrobe, dress
from sim1.policy.image_trials.pilot import ImagePilot
from sim1.policy.image_trials.stage import ImageTrialsConfig
from sim1.policy.lessons import ModelKey
from sim1.policy.trial_crew import STRIP
from sim1.policy.trials import TRIAL_COLUMNS, Bench, Trial, TrialSettings, drive, open_bench
from sim1.quota import Row, Ticket
from sim1.render.film_set import FilmSet
from sim1.render.live_camera import LiveCamera
from sim1.render.looks.draw import read_looks
from sim1.stage import Inputs, only, random_stream

COLUMNS = (*TRIAL_COLUMNS, *LOOK_COLUMNS, "picture_count")


@dataclass(frozen=True, kw_only=True)
class Plan:
    """All trials of the networks of an image policy."""

    inputs: Inputs
    policies: Path  # of folders that lerobot reads, by the network's seed
    device: str
    chunk_frames: int
    models: tuple[ModelKey, ...]
    wardrobes: Mapping[str, Wardrobe]  # by garment
    settings: TrialSettings
    config: ImageTrialsConfig
    files: Path  # folder for what cameras keep while they are there

    @property
    def trials(self) -> list[Trial]:
        """In the order of the table."""
        return [
            Trial(model=model, garment=garment, shift=shift, number=number)
            for garment in self.wardrobes
            for model in self.models
            for shift in self.config.shifts
            for number in range(self.config.trial_count)
        ]

    @property
    def processes(self) -> int:
        return self.config.processes or os.process_cpu_count() or 1


@dataclass(frozen=True, kw_only=True)
class Driver:
    """Makes trials (`sim1.crew.Maker`)."""

    plan: Plan
    _trials: Mapping[str, Trial]
    _networks: dict[ModelKey, Trained] = field(default_factory=dict)  # one: they come one after the other
    _benches: dict[tuple[str, float], Bench] = field(default_factory=dict)
    _cameras: dict[str, LiveCamera] = field(default_factory=dict)  # one: garments come one after the other

    @classmethod
    def of(cls, plan: Plan) -> "Driver":
        """One thread a process: there are as many processes as are wanted."""
        torch.set_num_threads(1)
        return cls(plan=plan, _trials={trial.name: trial for trial in plan.trials})

    def make(self, ticket: Ticket, folder: Path) -> Row:
        """Drive; the row (`COLUMNS`), and the film strip in `folder`."""
        trial, config = self._trials[ticket.name], self.plan.config
        place = trial.garment, trial.friction_factor(config)
        if place not in self._benches:
            self._benches[place] = open_bench(self.plan.inputs, trial.garment, config.trials_in, place[1])
        row, film = self.run(trial, self._benches[place], self._camera(trial.garment))
        write_strip(folder / STRIP, strip_of(row, film, self.plan.settings.driving.stride))
        return {**row, "ran": True}

    def run(self, trial: Trial, bench: Bench, camera: LiveCamera) -> tuple[Row, list[tuple[int, np.ndarray]]]:
        """The row, and what the policy saw (`ImagePilot.film`)."""
        seen = dress_of(self.plan, trial)
        camera.show(seen.clip)
        task = self.plan.wardrobes[trial.garment].task
        pilot = ImagePilot(self.network(trial.model), self.plan.chunk_frames, task, camera.pictures)
        chance = random_stream(self.plan.config.seed, "policy's chance", trial.garment, trial.model.seed, trial.number)
        with seeded_context(int(chance.integers(2**31))):
            row, _ = drive(bench, trial, pilot, self.plan.settings)
        return {**row, **seen.columns, "picture_count": len(pilot.film)}, pilot.film

    def network(self, model: ModelKey) -> Trained:
        """Ready to drive."""
        if model not in self._networks:
            self._networks.clear()
            self._networks[model] = load(self.plan.policies / str(model.seed), self.plan.device)
        return self._networks[model]

    def _camera(self, garment: str) -> LiveCamera:
        if garment not in self._cameras:
            while self._cameras:
                self._cameras.popitem()[1].close()
            inputs, config = self.plan.inputs, self.plan.wardrobes[garment].config
            film_set = FilmSet.of(inputs["garment_mesh"][garment], inputs["scene"][garment], config.cameras)
            threads = max(1, (os.process_cpu_count() or 1) // self.plan.processes)
            self._cameras[garment] = LiveCamera(film_set, replace(config, threads=threads), self.plan.files)
        return self._cameras[garment]


def dress_of(plan: Plan, trial: Trial) -> Dress:
    """What a trial looks like."""
    return dress(
        trial,
        plan.wardrobes[trial.garment],
        read_looks(only(plan.inputs, "appearance")),
        seed=plan.config.seed,
        viewpoint_rad=float(np.radians(plan.config.viewpoint_deg)),
        frame_count=plan.settings.driving.frame_count(plan.settings.limits[trial.garment].duration_s),
    )


def strip_of(row: Mapping[str, Any], film: list[tuple[int, np.ndarray]], stride: int) -> FilmStrip:
    """The very pictures that the policy saw, and in what. `stride`: cell frames per policy frame."""
    shown = [film[place] for place in evenly(len(film))]
    rubbing = f", friction × {row['friction_factor']:g}" if row["friction_factor"] != 1.0 else ""
    placed = laid_down(row["shift_x_m"], row["shift_y_m"], row["turn_rad"])
    return FilmStrip(
        title=f"{row['garment']}, network seed {row['seed']}, trial {row['trial']}, {placed}; {row['fabric']} on {row['table']}, light {row['light']}, "
        f"camera {row['elevation_deg']:+.0f}°{rubbing}",
        times_s=tuple(frame * stride / RATE_HZ for frame, _ in shown),
        pictures=tuple(picture for _, picture in shown),
    )
