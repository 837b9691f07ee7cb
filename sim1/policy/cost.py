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
FRAMES_BY = "rendered_episodes"
PER_TRAJECTORY_STAGES = (*MADE_BY, *SHOWN_BY)

type Timings = Mapping[str, Mapping[str, float | None]]
"""Stage -> garment ("" for a joint stage) -> seconds that making all of the artifact took; None where nobody knows.

A stage of the graph of which nothing had been made has an empty mapping.
"""


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


@dataclass(frozen=True, kw_only=True)
class Pace:
    """Seconds of machine time that the stages take which every trajectory passes."""

    attempted_s: float  # to simulate and judge an attempt, whatever becomes of it
    accepted_s: float  # the same for each one that is accepted: those that are not are paid for by these
    shown_s: float  # to render one, in all of its appearances, and to write it into the dataset
    frames_share: float  # of all seconds of a trajectory that is accepted and shown, those that make its frames

    @property
    def trajectory_s(self) -> float:
        """An accepted trajectory with its frames, in the dataset."""
        return self.accepted_s + self.shown_s


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


def this_machine(prices: Prices, pace: Pace | None) -> Production | None:
    """The machine at hand around the clock at the measured pace; None where that is not known."""
    if pace is None:
        return None
    return Production(
        method=f"Simulation ({prices.this_machine.description})",
        usd_per_day=prices.this_machine.usd_per_hour * HOURS_PER_DAY,
        trajectories_per_day=HOURS_PER_DAY * 3600 / pace.trajectory_s,
    )


def pace_of(timings: Timings, attempted_count: int, accepted_count: int, shown_count: int) -> Pace | None:
    """Of this machine; None where nothing was accepted or shown, what one artifact of these stages took is not known, or all took no time.

    Args:
        timings: of all stages.
        attempted_count: attempts that `valid_trajectories` judged, those that were out of reach or disturbed on purpose included.
        accepted_count: trajectories of `valid_trajectories`.
        shown_count: those of them that the dataset shows.
    """
    missing = [s for s in PER_TRAJECTORY_STAGES if not timings.get(s) or None in timings[s].values()]
    if missing or not accepted_count or not shown_count:
        return None
    spent_s = {stage: sum(timings[stage].values()) for stage in PER_TRAJECTORY_STAGES}
    made_s, shown_s = (sum(spent_s[stage] for stage in stages) for stages in (MADE_BY, SHOWN_BY))
    each_s = made_s / accepted_count + shown_s / shown_count
    if not each_s:
        return None
    return Pace(
        attempted_s=made_s / attempted_count,
        accepted_s=made_s / accepted_count,
        shown_s=shown_s / shown_count,
        frames_share=spent_s[FRAMES_BY] / shown_count / each_s,
    )


def read_timings(path: Path) -> Timings:
    """Read `{stage: {garment: seconds}}`; null where nobody knows, nothing of a stage of which nothing was made yet.

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
