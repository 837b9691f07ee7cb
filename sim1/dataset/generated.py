"""A dataset of a folder of `sim1 generate`: its accepted episodes rendered and written as the stages of the pipeline do it."""

import json
import shutil
import tempfile
from pathlib import Path
from typing import Any

import pandas as pd

from sim1.dataset.decisions import FILE as DECISIONS
from sim1.dataset.decisions import SAID
from sim1.dataset.stage import DatasetConfig, check_dataset, dataset
from sim1.progress import within
from sim1.render.stage import RenderConfig, check_rendered_episodes, rendered_episodes
from sim1.stage import BadInput, Facts, Finding, Inputs

RENDERING = 0.95  # of the progress bar


def dataset_of_generated(
    folder: Path, inputs: Inputs, garment: str, render: RenderConfig, config: DatasetConfig, out: Path
) -> Facts:
    """Render into `out/rendered`, which a killed run goes on with, and write `out/dataset`, an artifact of stage `dataset`.

    Trajectories are named after the seed, so that they stay apart from those of the stage and of other seeds when datasets are merged.

    Args:
        folder: of `sim1 generate`, finished or not.
        inputs: garment_mesh, scene, calibrated_physics and mismatch_report of the garment, sources appearance, robot and owner.
        garment: its name.
        render: how to render.
        config: how to write.
        out: folder.

    Raises:
        BadInput: nothing was accepted, an input or a frame is at fault, or `out/dataset` exists.
        BlenderFailed: a process of Blender could not finish.
    """
    final, part, rendered = (out / name for name in ("dataset", "dataset.part", "rendered"))
    if final.exists():
        raise BadInput(f"{final}: exists; give another folder")
    episodes, decisions = accepted_episodes(folder), made_decisions(folder)
    rendered.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as links:
        place = Path(links) / "episodes"
        place.mkdir()
        for name, path in episodes.items():
            (place / name).symlink_to(path.resolve())
        decisions.to_parquet(Path(links) / DECISIONS, index=False)
        inputs = {**inputs, "valid_trajectories": {garment: Path(links)}}
        with within(0.0, RENDERING):
            rendered_episodes(inputs, rendered, render)
        _require(check_rendered_episodes(rendered), rendered)
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir()
        with within(RENDERING, 1.0):
            facts = dataset({**inputs, "rendered_episodes": {garment: rendered}}, part, config)
    _require(check_dataset(part), part)
    part.rename(final)
    return facts


def accepted_episodes(folder: Path) -> dict[str, Path]:
    """Folders of the episodes that passed all filters, by a name that tells the seed.

    Raises:
        BadInput: this is no folder of `sim1 generate`, a row is damaged, or nothing was accepted.
    """
    rows = _attempts(folder)
    accepted = {name: folder / "episodes" / row["episode"] for name, row in rows.items() if row["accepted"]}
    if not accepted:
        raise BadInput(f"{folder}: none of {len(rows)} attempts was accepted; `sim1 generate` makes more of them")
    return accepted


def made_decisions(folder: Path) -> pd.DataFrame:
    """What the filters said of every attempt, under the same names: columns as `valid_trajectories` has them.

    Raises:
        BadInput: this is no folder of `sim1 generate`, or a row is damaged.
    """
    try:
        rows = [{"episode": name, **{key: row[key] for key in SAID}} for name, row in _attempts(folder).items()]
    except KeyError as error:
        raise BadInput(f"{folder}/attempts: an attempt has no {error}; make the folder again") from error
    return pd.DataFrame(rows)


def _attempts(folder: Path) -> dict[str, dict[str, Any]]:
    """Rows by the name that an episode gets in a dataset."""
    try:
        seed = json.loads((folder / "plan.json").read_text())["setting.seed"]
        rows = [json.loads(path.read_text()) for path in sorted((folder / "attempts").glob("*.json"))]
        return {f"seed{seed}_{row['episode']}": row for row in rows}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{folder}: not a readable folder of `sim1 generate` ({error!r}); make it again") from error


def _require(findings: list[Finding], folder: Path) -> None:
    """Raises BadInput at a failed blocking finding."""
    for finding in findings:
        if finding.blocking and not finding.passed:
            raise BadInput(f"{folder}: {finding.name}: {finding.detail}")
