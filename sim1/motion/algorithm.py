"""Algorithm 1 of the paper as a program of its own: attempts until enough pass judge, state rules and video discriminator.

The stage candidate_trajectories makes the few attempts from which the filters learn. This makes any number more, from another
seed, so that the filters judge what they have not seen.
"""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sim1.crew import finished, labour_together
from sim1.episode import read_start
from sim1.motion.bench import Bench
from sim1.motion.generation import write_tables
from sim1.quota import Quota, Row, Ticket
from sim1.stage import BadInput, Inputs, only
from sim1.validity.deciding import Filters, decision, read_filters
from sim1.validity.outcomes import outcome

if TYPE_CHECKING:
    from sim1.motion.stage import CandidateTrajectoriesConfig
    from sim1.validity.stage import ValidTrajectoriesConfig

SCHEMA = "sim1.generation/1"
COUNTS = {
    "candidate_count", "more_of", "success_target", "run_limit", "perturbed_count", "tries_per_candidate",
}  # of the stage  # fmt: skip
TRIES_PER_TARGET = 100  # a garment of which fewer pass is not worth the electricity: the run ends and says so


@dataclass(frozen=True, kw_only=True)
class Checked:
    """A maker of attempts that also asks the filters."""

    bench: Bench
    filters: Filters

    @classmethod
    def of(
        cls, inputs: Inputs, garment: str, config: CandidateTrajectoriesConfig, valid: ValidTrajectoriesConfig
    ) -> Checked:
        """Read what both stages are given; raises BadInput."""
        return cls(bench=Bench.of(inputs, garment, config), filters=read_filters(inputs, valid))

    def make(self, ticket: Ticket, folder: Path) -> Row:
        """The attempt's row, with what the filters say of it."""
        row = self.bench.make(ticket, folder)
        said = decision(row, folder, self.filters)
        failure = row["failure"] if said["accepted"] else outcome(row | said)
        names = ("rules_pass", "rules_broken", "video_score", "video_pass", "video_abstains", "accepted", "reasons")
        return row | {name: said[name] for name in names} | {"failure": failure}


def generate_until(
    inputs: Inputs,
    garment: str,
    variant: str | None,
    configs: tuple[CandidateTrajectoriesConfig, ValidTrajectoriesConfig],
    made_from: dict[str, str],
    code: dict[str, str],
    out: Path,
    target: int,
    workers: int,
    tell: Callable[[dict[str, Row]], None],
) -> list[Row]:
    """Make attempts in `out` until `target` are accepted; a folder that was begun goes on, also with another target.

    Args:
        inputs: of the stages candidate_trajectories and valid_trajectories.
        garment: its name.
        variant: of the graph that the inputs are taken from; None is the base.
        configs: of the same two stages; the first one's counts have no influence.
        made_from: stage -> data version of the inputs.
        code: function and version of the same two stages, by name.
        out: folder.
        target: accepted episodes wanted.
        workers: processes.
        tell: hears of the rows that are made.

    Returns:
        Rows of all attempts, in order.

    Raises:
        BadInput: an input is at fault, or `out` was begun with other inputs, settings or code.
        CrewDied: processes died before enough was made; what is made stays.
    """
    config, valid = configs
    plan = {"schema": SCHEMA, "garment": garment, "variant": variant}
    plan |= {f"setting.{name}": value for name, value in asdict(config).items() if name not in COUNTS}
    plan |= {f"filter.{name}": value for name, value in asdict(valid).items()}
    plan |= {f"input.{name}": version for name, version in made_from.items()}
    plan |= {f"code.{name}": what for name, what in code.items()}
    _claim(out / "plan.json", plan)
    limit = TRIES_PER_TARGET * target
    quota = Quota(series="", run_count=0, target=target, counted="accepted", run_limit=limit, try_limit=limit)
    labour_together(out, [quota], functools.partial(Checked.of, inputs, garment, config, valid), workers, tell)
    start_m = read_start(only(inputs, "seed_demos"))
    return finished(out, lambda rows: write_tables(out, rows, start_m))


def _claim(path: Path, plan: dict[str, Any]) -> None:
    """Note what the attempts of a folder are made from, or check that they are made from this.

    Raises:
        BadInput: they are made from something else, or nobody can say from what.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(f".{os.getpid()}.part")
    part.write_text(json.dumps(plan, indent=1, sort_keys=True) + "\n")
    try:
        path.hardlink_to(part)  # whole at once, and of several that begin the folder only the first does
        return
    except FileExistsError:
        pass
    finally:
        part.unlink()
    try:
        begun = json.loads(path.read_text())
        changed = [name for name in sorted({*plan, *begun}) if plan.get(name) != begun.get(name)]
    except (ValueError, AttributeError, TypeError) as error:
        raise BadInput(
            f"{path}: not readable ({error}), so what the attempts beside it are made from is unknown; "
            "give another folder, or remove this one"
        ) from None
    if changed:
        raise BadInput(
            f"{path}: {changed[0]} was {begun.get(changed[0], 'not noted')} when this folder was begun, is "
            f"{plan.get(changed[0], 'no setting')} now; give another folder, or remove this one"
        )
