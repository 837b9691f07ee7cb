"""What each part of the diagnosis is worth: the same bundles with a part left out.

| column | what is left out |
| --- | --- |
| whole | nothing |
| no veto | motion held out: what fits best is believed, however it foretells |
| nothing measured | errors of mesh and step, and wobble: residuals are set against the markers' noise alone |
| screening alone | simulation of the candidates: the best of the shortlist is the name |
| not orthogonal | and what the baseline's parameters can imitate is left in the fingerprints |
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.diagnosis.asked import each_once
from sim1.cloth.precise.world import World
from sim1.mismatch.contest import contest
from sim1.mismatch.decide import Decision, decide
from sim1.mismatch.diagnose import Diagnosis, delays_measured, diagnose
from sim1.mismatch.engine import Engine, Looked
from sim1.mismatch.fit import fit, temper_of
from sim1.mismatch.heldout import held_out
from sim1.mismatch.screen import screen, site_of
from sim1.mismatch.search import Unknowns, baseline
from sim1.mismatch.thresholds import THRESHOLDS
from sim1.proof.answers import kind_of
from sim1.proof.outcome import is_right
from sim1.recording.bundle import Bundle

COLUMNS = ("whole", "no veto", "nothing measured", "screening alone", "not orthogonal")
Said = tuple[str, tuple[str, ...]]  # verdict, names


class Unmeasured(Engine):
    """Knows of no error but the markers' noise."""

    def refine(self, world: World, names: tuple[str, ...]) -> None:
        """Nothing."""

    def soften(self, unknowns: Unknowns, z: np.ndarray, names: tuple[str, ...]) -> Looked:
        """Slopes alone."""
        return self.slopes(unknowns, z, names)


def ablation(folders: list[Path], out: Path, tell: Callable[[str], None]) -> str:
    """A Markdown table: what every variant says of each case (folders as `asked.py` knows them); right ones are counted.

    Writes OUT/CASE.json after each case, and asks no case twice.
    """
    rows, right = [], dict.fromkeys(COLUMNS, 0)
    for answers, found in each_once(folders, out, "with parts left out", _said, tell):
        said = {label: (verdict, tuple(names)) for label, (verdict, names) in found.items()}
        concealed = tuple(effect.name for effect in answers.effects)
        cells = []
        for label in COLUMNS:
            good = is_right(kind_of(answers), concealed, *said[label])
            right[label] += good
            cells.append(" ".join((said[label][0], " + ".join(said[label][1]), "" if good else "(wrong)")).strip())
        rows.append(f"| {' + '.join(concealed) or 'nothing'} | {' | '.join(cells)} |")
    counts = " | ".join(f"{right[label]} of {len(folders)}" for label in COLUMNS)
    head = [f"| concealed | {' | '.join(COLUMNS)} |", "| --- " * (len(COLUMNS) + 1) + "|"]
    return "\n".join([*head, *rows, f"| right | {counts} |"])


def _said(bundle: Bundle) -> dict[str, Said]:
    measured, fitted = delays_measured(bundle), tuple(r.name for r in bundle.recordings if r.name != held_out(bundle))
    whole = diagnose(bundle)
    found = {
        "whole": (whole.verdict, whole.chosen.terms),
        "no veto": _of(decide(list(whole.models), THRESHOLDS, measured)),
        **_shortlisted(bundle, whole, fitted),
    }
    with Unmeasured(bundle) as engine:
        pool = contest(engine, baseline(bundle), fitted, THRESHOLDS, lambda share, what: None).pool
        found["nothing measured"] = _of(decide(pool, THRESHOLDS, measured))
    return found


def _of(decision: Decision) -> Said:
    return decision.verdict, decision.chosen.terms


def _shortlisted(bundle: Bundle, whole: Diagnosis, names: tuple[str, ...]) -> dict[str, Said]:
    """What the best fingerprint says, with and without what the baseline can imitate taken out."""
    base, said = whole.baseline.fit, {}
    with Engine(bundle) as engine:
        engine.refine(base.unknowns.world(base.z), names)
        looked = engine.soften(base.unknowns, base.z, names)
        base = fit(engine, base.unknowns, base.z, names, temper=base.temper, most=0, given=looked)
        base = replace(base, temper=temper_of(engine, base.residuals, names))
        fixed = replace(base, slopes={name: np.zeros_like(slopes) for name, slopes in base.slopes.items()})
        for label, one in (("screening alone", base), ("not orthogonal", fixed)):
            first = screen(engine, one, site_of(engine, one.unknowns.world(one.z)), names)[0]
            gains = first.gain >= THRESHOLDS.named
            said[label] = ("named", (first.term.effect.name,)) if gains else ("none", ())
    return said
