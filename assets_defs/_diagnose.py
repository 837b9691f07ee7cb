"""`sim1 diagnose` and `sim1 predict`: what a simulator leaves out, and motion foretold with it put in.

`sim1 prove` starts them by `python -m assets_defs._diagnose`: so that what it hashes is what diagnoses, and no other command with it.
"""

from pathlib import Path
from typing import Annotated

import typer

from assets_defs._open import stop
from assets_defs._progress import bar

Bundle = Annotated[Path, typer.Argument(help="Folder with bundle.yaml, format sim1.recordings/1.")]


def diagnose(
    bundle: Bundle,
    out: Annotated[
        Path,
        typer.Option(
            help="Folder for verdict.json, summary.json, model.yaml, baseline.yaml, forces.npz and report.html."
        ),
    ],
    budget_minutes: Annotated[
        float | None,
        typer.Option(
            min=0.5,
            help="Stop searching in time to report what is known after so long; simulating every recording from rest three times is the least.",
        ),
    ] = None,
) -> None:
    """Locate, name and model the physics that the simulator leaves out of recordings.

    Ctrl-C or `kill` ends the search; what is known by then is written. A second one ends the program. baseline.yaml is written as soon as
    the baseline is calibrated.
    """
    from sim1.cloth.precise.simulate import NotConverged
    from sim1.stage import BadInput

    try:
        with bar(1.0) as tell:
            from sim1.mismatch.findings import run_diagnosis
            from sim1.mismatch.verdict import in_mm

            verdict = run_diagnosis(bundle, out, tell, budget_minutes and 60 * budget_minutes)
    except (BadInput, NotConverged) as error:
        stop(str(error))
    names = ", ".join(effect.name for effect in verdict.missing_physics) or "-"
    before, after = (in_mm(errors.heldout) for errors in (verdict.rmse_m.baseline, verdict.rmse_m.augmented))
    print(f"{verdict.verdict}: {names}; held-out error {before} -> {after}; {out / 'report.html'}")
    for remark in verdict.remarks:
        print(f"note: {remark}")


def predict(
    bundle: Bundle,
    model: Annotated[Path, typer.Option(help="model.yaml or baseline.yaml of a diagnosis.")],
    out: Annotated[Path, typer.Option(help="Parquet file to write.")],
) -> None:
    """Simulate every recording of a bundle from its rest state and its drives alone."""
    from sim1.cloth.precise.simulate import NotConverged
    from sim1.stage import BadInput

    try:
        with bar(1.0) as tell:
            from sim1.mismatch.predict import predict_files

            rows = predict_files(bundle, model, out, tell)
    except (BadInput, NotConverged) as error:
        stop(str(error))
    print(f"{rows} rows in {out}")


if __name__ == "__main__":
    alone = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    alone.command()(diagnose)
    alone.command()(predict)
    alone()
