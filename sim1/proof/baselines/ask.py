"""Ask the methods that cost simulations; what they said is kept, case by case."""

import time
from pathlib import Path

from sim1.cloth.physics import ClothPhysics, read_physics
from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.strict_json import read_json
from sim1.proof.again import Films
from sim1.proof.baselines.residual import heldout_m
from sim1.proof.baselines.sindy import pysindy_stlsq, sparse_effects
from sim1.proof.files import Baselines, Files, Generic, Sparse, write_model
from sim1.proof.outcome import Outcome
from sim1.recording.bundle import Bundle, read_bundle


def ask_baselines(films: Films, outcomes: tuple[Outcome, ...]) -> None:
    """Ask of every case that has been diagnosed and not been asked yet, first the quicker method of all cases, then the other.

    They are given the bundle and the calibrated baseline, no answers. A case whose `baseline.yaml` stayed where it was diagnosed is told.

    Raises:
        BadInput: PySINDy is not installed, or a bundle, a calibrated baseline or an earlier answer is damaged.
    """
    pysindy_stlsq()  # before hours of work rather than after
    files, asked = films.files, []
    for one in outcomes:
        if one.found and _baseline(files, one.case).is_file():
            asked.append(one)
        elif one.found:
            films.tell(
                f"{one.case}: not asked, as {_baseline(files, one.case)} stayed where it was diagnosed; bring it"
            )
    for field, ask in (("sindy", ask_sparse), ("residual", ask_generic)):
        for number, one in enumerate(asked, start=1):
            path = files.baselines(one.case)
            told = one.baselines or Baselines(case=one.case)
            known = read_json(path, Baselines, "remove it and ask again") if path.is_file() else told
            if getattr(known, field) is None and (filmed := films.of(one.case)) is not None:
                bundle = read_bundle(filmed.bundle(one.case))
                answer = ask(bundle, read_physics(_baseline(files, one.case)), one.found.heldout_of(bundle))
                write_model(path, known.model_copy(update={field: answer}))
                films.tell(f"{one.case}: {_told(answer)}; {number} of {len(asked)} asked")


def _baseline(files: Files, case: str) -> Path:
    return files.found(case) / "baseline.yaml"


def ask_sparse(bundle: Bundle, calibrated: ClothPhysics, held: str) -> Sparse:
    """Sparse regression on a case, and its error on the recording `held`."""
    began = time.monotonic()
    try:
        said = sparse_effects(bundle, calibrated, held)
    except NotConverged:
        return Sparse(named=None, heldout_mm=None, seconds=_since(began))
    off_mm = None if said.heldout_m is None else 1e3 * said.heldout_m
    return Sparse(named=said.effects, heldout_mm=off_mm, seconds=_since(began))


def ask_generic(bundle: Bundle, calibrated: ClothPhysics, held: str) -> Generic:
    """A residual without a name, fitted to a case, and its error on the recording `held`."""
    began = time.monotonic()
    off_m = heldout_m(bundle, calibrated, held)
    return Generic(heldout_mm=None if off_m is None else 1e3 * off_m, seconds=_since(began))


def _since(began: float) -> float:
    return round(time.monotonic() - began, 3)


def _told(answer: Sparse | Generic) -> str:
    off = "finds no way" if answer.heldout_mm is None else f"is off by {answer.heldout_mm:.2f} mm"
    if isinstance(answer, Generic):
        return f"a residual without a name {off}"
    names = "nothing, as the baseline finds no way" if answer.named is None else " + ".join(answer.named) or "none"
    return f"sparse regression says {names} and {off}"
