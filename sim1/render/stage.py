"""Stage `rendered_episodes`: accepted trajectories as photographs, several appearances each (paper section 3.4)."""

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from sim1.stage import Facts, Finding, Inputs, garment_of, only, stage_config

if TYPE_CHECKING:
    from sim1.render.job import Job

REDRAWN_AT_MOST = (
    3  # times that an appearance is drawn anew where the garment is not seen; of 90 drawn ones one was not
)


@stage_config
class RenderConfig:
    """How trajectories are rendered."""

    seed: int = Field(default=0, ge=0, lt=2**31)  # of appearances and of Cycles' sampling
    variants: int = Field(default=2, ge=1)  # appearances per trajectory, K of the paper's algorithm 1
    shared_looks: int = Field(
        default=0, ge=0
    )  # appearances that all trajectories are dealt out to; 0: each draws its own
    rate_hz: Literal[1, 2, 3, 5, 6, 10, 15, 30] = 10  # pictures per second: what divides the 30 Hz of the states
    max_episodes: int = Field(default=0, ge=0)  # render only that many trajectories; 0 is all
    cameras: Annotated[tuple[str, ...], Field(min_length=1)] = ("head",)  # of the scene: head, left_wrist, right_wrist
    engine: Literal["cycles", "workbench"] = "cycles"  # workbench: a preview without light, tens of frames a second
    width: int = Field(default=96, ge=16, multiple_of=2)  # px; even, because video codecs halve the colour planes
    height: int = Field(default=72, ge=16, multiple_of=2)  # px
    samples: int = Field(default=4, ge=1)  # light paths per pixel
    denoise: bool = True  # OpenImageDenoise; what makes few samples do
    elevation_jitter_deg: float = Field(
        default=5.0, ge=0.0, le=30.0
    )  # of the head camera about the table's middle (paper, section 4.1)
    scanned_share: float = Field(default=0.5, ge=0.0, le=1.0)  # of appearances that keep the garment's measured texture
    device: Literal["auto", "cpu", "gpu"] = "auto"  # gpu is not deterministic to the bit
    # How many do it changes no byte of a frame, and so is no part of the recipe.
    workers: int = Field(default=0, ge=0, exclude=True)  # Blender processes; 0 is one per core, on a GPU one
    threads: int = Field(default=0, ge=0, exclude=True)  # of each worker's Cycles on a CPU; 0 shares the cores out


def rendered_episodes(inputs: Inputs, out: Path, config: RenderConfig) -> Facts:
    """Render every accepted trajectory in `config.variants` appearances, frames in step with the states.

    Frames that `out` already holds are kept where they show what is to be rendered, so that a killed run goes on where it was,
    and a changed fabric costs the frames that show it. An appearance in which the garment turns out not to be seen, as a metal table may
    mirror a light of the cloth's brightness, is drawn anew; one that stays unseen is left to the check.

    Raises:
        BadInput: damaged inputs or looks, or an unknown camera.
        BlenderFailed: a process of Blender could not finish.
    """
    from sim1.render.drawn_again import forget_hidden, note_hidden, read_hidden, work_of
    from sim1.render.pictures import write_contact_sheet
    from sim1.render.visible import hidden_clips

    garment = garment_of(inputs)
    work = work_of(inputs, garment, config)
    draws = read_hidden(out, work)
    again = Counter(clip for hidden in draws for clip in hidden)
    job = _render(inputs, garment, out, config, again)
    while len(draws) < REDRAWN_AT_MOST and (hidden := hidden_clips(out)):
        again.update(hidden)
        draws.append(hidden)
        note_hidden(out, work, draws)
        job = _render(inputs, garment, out, config, again)
    write_contact_sheet(out, title=f"{garment}: rendered episodes")
    forget_hidden(out)
    looks = [clip.appearance for clip in job.clips]
    return {
        "episodes": len({clip.episode for clip in job.clips}),
        "clips": len(job.clips),
        "frames": job.frame_count,
        "drawn_again": sum(again.values()),
        "fabrics": _counted("fabric", [look.fabric.name for look in looks]),
        "tables": _counted("table", [look.table.name for look in looks]),
        "rooms": _counted("room", [look.room.name for look in looks]),
    }


def _render(
    inputs: Inputs, garment: str, out: Path, config: RenderConfig, again: Mapping[tuple[str, int], int]
) -> "Job":
    """Bring `out` to what is planned with appearances drawn `again` so often; what it holds of that is not rendered."""
    import tempfile

    from sim1.render.blender import run_blender
    from sim1.render.plan import drawn, plan_job

    with tempfile.TemporaryDirectory() as folder:
        job = plan_job(
            trajectories=only(inputs, "valid_trajectories"),
            mesh=only(inputs, "garment_mesh"),
            scene=only(inputs, "scene"),
            choice=drawn(only(inputs, "appearance"), garment, config, again),
            garment=garment,
            out=out,
            folder=Path(folder),
            config=config,
        )
        if job.frame_count:
            run_blender(Path(folder), out)
    return job


def check_source_appearance(path: Path) -> None:
    """Raises BadInput at a fault in the files of looks."""
    from sim1.render.looks.draw import read_looks

    read_looks(path)


def check_rendered_episodes(artifact: Path) -> list[Finding]:
    """Frames in step with the states, of the right size, lit, and with the garment to be seen."""
    from sim1.render.check import check_frames

    return check_frames(artifact)


def _counted(what: str, names: list[str]) -> list[dict[str, str | int]]:
    return [{what: name, "clips": count} for name, count in sorted(Counter(names).items())]
