"""Demonstrations by the scripted expert: stages `seed_demos` and, in what plays reality, `real_demos`."""

from pathlib import Path

from pydantic import Field

from sim1.stage import Facts, Finding, Inputs, garment_of, only, stage_config


@stage_config
class SeedDemosConfig:
    """How many demonstrations, how they vary, and how finely the cloth is simulated."""

    demo_count: int = Field(2, ge=1)  # successes wanted
    attempts: int = Field(4, ge=1)  # at most this many tries; failures are kept and labelled
    seed: int = 0  # of the variation
    substeps: int = Field(8, ge=2, multiple_of=2)  # of the cloth solver per 1/30 s
    iterations: int = Field(5, ge=1)  # of the cloth solver per substep
    settle_s: float = Field(4.0, gt=0)  # at most, from the lying pose to rest: the shipped garments take 0.4 to 2.0
    rest_speed_m_s: float = Field(0.03, gt=0)  # slower than this is at rest
    laid_m: float = Field(0.0, ge=0)  # radius within which the garment is laid down anew for every demonstration
    grasp_std_m: float = Field(0.004, ge=0)  # spread of grasp points between demonstrations
    pace_std: float = Field(0.10, ge=0)  # spread of the logarithm of the pace
    replay_s: float = Field(
        2.5, gt=0
    )  # of one demonstration that is simulated again to prove that commands reproduce it
    queue: int = Field(2, ge=1)  # episodes that may wait for the writer thread


@stage_config
class RealDemosConfig(SeedDemosConfig):
    """Demonstrations in what plays reality: finer steps and mesh than the simulator's, and nobody lays a garment down twice alike."""

    garments: tuple[str, ...] = ("towel",)  # that are demonstrated there; of others there are none
    seed: int = 1000  # other variations than the seed demonstrations'
    substeps: int = Field(16, ge=2, multiple_of=2)
    finer_mesh: bool = True  # of the garment: every triangle cut (`sim1.cloth.bisect`)
    laid_m: float = Field(0.01, ge=0)


def seed_demos(inputs: Inputs, out: Path, config: SeedDemosConfig) -> Facts:
    """Settle the garment on the table, then demonstrate its task.

    Writes `episodes/NNNN/` with `session.usdc`, `start.npz`, `task.json` and pictures. Where a person teleoperated (SIM1, section on
    data collection; `data/demonstrations/GARMENT/`, a LeRobot dataset), the arms follow those commands, all of them. Else a scripted
    expert stands in until enough runs succeeded. Gripping is by finger contact and friction alone.

    Raises:
        BadInput: a damaged input, or a garment that does not come to rest on the table.
    """
    from sim1.robot.demonstrations import record

    return record(inputs, out, config, physics=only(inputs, "calibrated_physics") / "cell.yaml")


def real_demos(inputs: Inputs, out: Path, config: RealDemosConfig) -> Facts:
    """The same in what plays reality: what collecting there costs, to compare generated trajectories with.

    No stage that makes training data sees them. Where reality is real cloth, or the garment is not among `config.garments`,
    there are none, and `none.json` says why.

    Raises:
        BadInput: as `seed_demos`.
    """
    import json

    from sim1.recording.reality import read_world
    from sim1.robot.demonstrations import record

    reality, garment = only(inputs, "reality"), garment_of(inputs)
    why = None
    if read_world(reality) is None:
        why = "there are recordings of real cloth, and no stand-in in which the scripted expert could demonstrate"
    elif garment not in config.garments:
        why = f"the settings ask for {', '.join(config.garments) or 'no garment'}"
    if why:
        (out / "none.json").write_text(json.dumps({"why": why}) + "\n")
        return {"demonstrations": f"none: {why}"}
    return record(inputs, out, config, physics=reality / "cell.yaml", finer_mesh=config.finer_mesh)


def check_source_task(path: Path) -> None:
    """Raises BadInput where the task file is at fault: before any work, rather than in the middle of it."""
    from sim1.robot.expert_task import read_task

    read_task(path)


def check_source_demonstrations(path: Path) -> None:
    """Raises BadInput where a person's demonstrations are at fault."""
    from sim1.robot.teleoperation import read_commands

    read_commands(path)


def check_seed_demos(artifact: Path) -> list[Finding]:
    """At least one success; joints within limits and speeds; finite; the first success replays to the same bytes."""
    from sim1.robot.session_check import findings

    return findings(artifact)


def check_real_demos(artifact: Path) -> list[Finding]:
    """The same; none where none were asked for."""
    import json

    if (artifact / "none.json").exists():
        return [
            Finding(
                name="none_is_said_why", passed=True, detail=json.loads((artifact / "none.json").read_text())["why"]
            )
        ]
    return check_seed_demos(artifact)
