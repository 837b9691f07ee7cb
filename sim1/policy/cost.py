"""What a trajectory costs: the paper's arithmetic from prices, and this machine's from measured seconds."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from sim1.data_file import read_data_file
from sim1.stage import BadInput, stage_config

SCHEMA = "sim1.prices/1"
HOURS_PER_DAY = 24
# Work that every further trajectory needs again; all the rest is done once per garment or once in all. The stages of
# the second line may be told to take but some of what those of the first accepted.
MADE_BY = ("candidate_trajectories", "valid_trajectories")
SHOWN_BY = ("rendered_episodes", "dataset")
PER_TRAJECTORY_STAGES = (*MADE_BY, *SHOWN_BY)

type Timings = Mapping[str, Mapping[str, float | None]]
"""Stage -> garment ("" for a joint stage) -> seconds that making all of the artifact took; None where nobody knows."""


@stage_config
class RealCollection:
    """A person teaches the real robot."""

    labour_usd_per_hour: float
    labour_hours_per_day: float
    platform_usd: float
    platform_days: float
    trajectories_per_day: float


@stage_config
class PaperSimulation:
    """The paper's GPU server."""

    gpu_count: int
    gpu_usd_per_hour: float
    gpu_minutes_per_trajectory: float


@stage_config
class ThisMachine:
    """The machine that made the artifacts."""

    description: str
    usd_per_hour: float


@stage_config
class Prices:
    """`prices.yaml`, money in US dollars."""

    real_collection: RealCollection
    paper_simulation: PaperSimulation
    this_machine: ThisMachine


@dataclass(frozen=True, kw_only=True)
class Production:
    """How many trajectories a way of working makes in a day, and what one of them costs."""

    method: str
    usd_per_day: float
    trajectories_per_day: float

    @property
    def usd_per_trajectory(self) -> float | None:
        return self.usd_per_day / self.trajectories_per_day if self.trajectories_per_day else None


def read_prices(path: Path) -> Prices:
    """Read and check a price file.

    Raises:
        BadInput: missing or unknown key, a price that is not a positive number.
    """
    prices = read_data_file(path, Prices, SCHEMA)
    for name in ("real_collection", "paper_simulation", "this_machine"):
        for key, value in vars(getattr(prices, name)).items():
            if isinstance(value, int | float) and not 0 < value < float("inf"):
                raise BadInput(f"{path}: {name}.{key} is {value}; prices and counts must be positive")
    return prices


def real_collection(prices: Prices) -> Production:
    """Paper, appendix "Cost-efficiency Analysis": wages and the platform written off by the day."""
    real = prices.real_collection
    daily = real.labour_usd_per_hour * real.labour_hours_per_day + real.platform_usd / real.platform_days
    return Production(
        method="Real-world collection (paper)",
        usd_per_day=daily,
        trajectories_per_day=real.trajectories_per_day,
    )


def paper_simulation(prices: Prices) -> Production:
    """Paper, same place: GPUs around the clock, each trajectory a fixed time on one GPU."""
    server = prices.paper_simulation
    return Production(
        method="Simulation (paper)",
        usd_per_day=server.gpu_count * server.gpu_usd_per_hour * HOURS_PER_DAY,
        trajectories_per_day=server.gpu_count * HOURS_PER_DAY * 60 / server.gpu_minutes_per_trajectory,
    )


def this_machine(prices: Prices, timings: Timings, accepted_count: int, shown_count: int) -> Production | None:
    """The machine at hand around the clock at the measured pace of the stages that every trajectory passes.

    None where a stage of the four was not measured, or nothing was accepted or rendered.
    """
    seconds = per_trajectory_seconds(timings, accepted_count, shown_count)
    if seconds is None:
        return None
    return Production(
        method=f"Simulation ({prices.this_machine.description})",
        usd_per_day=prices.this_machine.usd_per_hour * HOURS_PER_DAY,
        trajectories_per_day=HOURS_PER_DAY * 3600 / seconds,
    )


def per_trajectory_seconds(timings: Timings, accepted_count: int, shown_count: int) -> float | None:
    """Seconds of machine time to have a trajectory accepted, rejected candidates included, and to show it.

    None where nothing was accepted or shown, what one artifact of these stages took is not known, or all took no time.

    Args:
        timings: of all stages.
        accepted_count: trajectories of `valid_trajectories`.
        shown_count: those of them that the dataset shows.
    """
    missing = [s for s in PER_TRAJECTORY_STAGES if not timings.get(s) or None in timings[s].values()]
    if missing or not accepted_count or not shown_count:
        return None
    made_s, shown_s = (sum(sum(timings[stage].values()) for stage in stages) for stages in (MADE_BY, SHOWN_BY))
    return made_s / accepted_count + shown_s / shown_count or None


def read_timings(path: Path) -> Timings:
    """Read `{stage: {garment: seconds}}`; null where nobody knows.

    Raises:
        BadInput: not such a file, or a time that is neither null nor a number of seconds.
    """
    try:
        found = json.loads(path.read_text())
        timings = {
            str(stage): {str(key): None if s is None else float(s) for key, s in times.items()}
            for stage, times in found.items()
        }
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise BadInput(
            f"{path}: not a file of {{stage: {{garment: seconds}}}} ({error}); remove or correct it"
        ) from error
    for stage, times in timings.items():
        for key, seconds in times.items():
            if seconds is not None and not 0 <= seconds < float("inf"):
                raise BadInput(f"{path}: {stage}/{key or 'joint'} took {seconds} s; correct the file")
    return timings
